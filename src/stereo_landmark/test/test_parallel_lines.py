import math

import numpy as np
import pytest
from antialiased_shapes import photograph
from seen_shapes import PRIMITIVES, box, polygon_light, polygon_photo, sides_of, turned_rectangle

from stereo_landmark.core.primitives.parallel_lines import (
    ParallelLines,
    ParallelLinesTolerance,
    detect_parallel_lines,
    refine_parallel_lines,
)
from stereo_landmark.core.primitives.primitive import Tolerances, difference

BAR = turned_rectangle((50, 45), 60.0, 12.0, 0.4)


def _found(corners, **photo):
    image = polygon_photo(corners, **photo)
    return image, detect_parallel_lines(sides_of(image), PRIMITIVES)[0]


@pytest.mark.parametrize('tilt', [0.0, 0.4, 1.5, -1.2])
def test_parameters_are_those_of_the_drawn_bar(tilt):
    _, lines = _found(turned_rectangle((50.3, 44.6), 60.0, 12.0, tilt))
    assert lines.width == pytest.approx(12.0, abs=0.15)
    assert lines.length == pytest.approx(57.0, abs=4.0)  # corners are round
    assert math.remainder(lines.tilt - tilt, math.pi) == pytest.approx(0.0, abs=0.01)
    assert -math.pi / 2 < lines.tilt <= math.pi / 2
    np.testing.assert_allclose(lines.centre, [50.3, 44.6], atol=1.0)
    assert lines.polarity == -1


def test_polarity_distinguishes_bright_dark_and_steps():
    _, dark = _found(BAR)
    _, bright = _found(BAR, ground=60.0, contrast=80.0)
    light = sum(polygon_light(box(-9, top, 109, 99), ground=30.0, contrast=60.0) for top in (30, 50))
    steps = detect_parallel_lines(sides_of(photograph(light, 1.0)), PRIMITIVES)[0]
    assert (dark.polarity, bright.polarity, steps.polarity) == (-1, 1, 0)
    assert difference(bright, dark, Tolerances()) == math.inf


def test_the_tilt_of_lines_is_that_of_an_undirected_line():
    """Tilts just above -pi/2 and just below pi/2 are near each other."""
    upright = [ParallelLines(6.0, 40.0, tilt, np.zeros(2), 1, np.eye(3), 1.0) for tilt in (1.55, -1.55)]
    assert difference(*upright, Tolerances()) == pytest.approx((math.pi - 3.1) / ParallelLinesTolerance().tilt)


def test_difference_grows_with_the_width():
    _, taught = _found(BAR)
    _, wider = _found(turned_rectangle((50, 45), 60.0, 16.0, 0.4))
    assert difference(taught, taught, Tolerances()) == 0.0
    expected = math.log(16 / 12) / math.log1p(0.45)
    assert difference(wider, taught, Tolerances()) == pytest.approx(expected, rel=0.1)


def test_refined_lines_are_unbiased_across_with_consistent_sigmas():
    rng = np.random.default_rng(0)
    rows = []
    for seed in range(40):
        tilt = rng.uniform(-1.5, 1.5)
        centre = np.array([50.0, 45.0]) + rng.uniform(-0.5, 0.5, 2)
        image, lines = _found(turned_rectangle(centre, 60.0, 12.0, tilt), seed=seed)
        refined = refine_parallel_lines(lines, image)
        assert refined is not None
        across = np.array([-math.sin(tilt), math.cos(tilt)])
        turn = math.remainder(refined.tilt - tilt, math.pi)
        error = np.array([(refined.centre - centre) @ across, turn, refined.width - 12.0])
        rows.append(error / np.sqrt(np.diag(refined.covariance)))
        assert abs(error[0]) < 0.04
        assert abs(error[2]) < 0.08
    spread = np.sqrt(np.mean(np.square(rows), axis=0))
    assert ((spread > 0.6) & (spread < 1.35)).all()


def test_the_centre_is_well_known_across_only():
    _, lines = _found(BAR)
    values, vectors = np.linalg.eigh(lines.image_points()['centre'].covariance)
    assert abs(vectors[:, 1] @ lines.direction) == pytest.approx(1.0, abs=1e-6)
    assert values[0] < 0.01 < 0.5 < values[1]
