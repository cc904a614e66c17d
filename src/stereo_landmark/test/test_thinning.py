"""Thinning in passes, the paper's control of edge extraction (3.3b, 4a)."""

import numpy as np
import pytest
from scipy.ndimage import label
from seen_shapes import PRIMITIVES, box, ellipse_photo, polygon_photo, segments_of

from stereo_landmark.core.edges.edges import thin
from stereo_landmark.core.primitives.ellipse import detect_ellipses

BAR = np.zeros((30, 60), dtype=bool)
BAR[10:19, 8:52] = True
EIGHT = np.ones((3, 3))


def test_each_pass_peels_a_layer_until_one_pixel_is_left():
    widths = [int(thin(BAR, passes)[:, 30].sum()) for passes in range(7)]
    assert widths == [9, 7, 5, 3, 1, 1, 1]


@pytest.mark.parametrize('seed', range(3))
def test_lines_stay_connected_and_on_the_edge(seed):
    rng = np.random.default_rng(seed)
    ring = np.hypot(*np.mgrid[-40:41, -40:41]) - rng.uniform(20, 30)
    thick = np.abs(ring) < 3.0
    thinned = thin(thick, 10)
    assert label(thinned, EIGHT)[1] == 1
    assert label(~thinned)[1] == 2
    assert not (thinned & ~thick).any()
    assert np.abs(ring[thinned]).max() < 1.5
    assert thinned.sum() < 0.25 * thick.sum()


def test_shapes_are_found_by_the_papers_edges():
    image = ellipse_photo((50.3, 44.8), (25.0, 20.0), 0.3)
    (found,) = detect_ellipses(segments_of(image, thinning=4.0), PRIMITIVES)
    assert found.centre == pytest.approx([50.3, 44.8], abs=0.3)
    assert found.semi_axes == pytest.approx([25.0, 20.0], abs=0.5)


def test_too_few_passes_leave_broken_edges():
    """Of an edge that is wider than a pixel, neighbours across it compete: what the engineer's slider is for."""
    image = polygon_photo(box(20, 20, 80, 70), blur=2.5, noise=0.5)
    longest = [np.diff(segments_of(image, thinning=passes, filter_sigma=2.0).starts).max() for passes in (1.0, 8.0)]
    assert longest[0] > longest[1] > 0
