import math

import numpy as np
import pytest
from seen_shapes import ellipse_photo, polygon_photo

from stereo_landmark.core.edges.edges import extract_edges, gaussian_gradient
from stereo_landmark.core.settings import EdgeSettings
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError


def test_edges_of_a_disc_are_on_its_outline_once_around():
    edges = extract_edges(ellipse_photo((50.3, 44.8), (25.0, 25.0), 0.0, noise=0.0), EdgeSettings())
    radii = np.hypot(*(edges.points - [50.3, 44.8]).T)
    assert np.abs(radii - 25.0).max() < 0.15
    assert radii.mean() == pytest.approx(25.0, abs=0.05)
    # One per row of a steep edge, one per column of a flat edge: 4 r / sqrt(2) times 2.
    assert len(edges.points) == pytest.approx(8 * 25.0 / math.sqrt(2.0), abs=4)


@pytest.mark.parametrize('angle', [0.0, 0.2, 0.785, 1.3])
def test_points_of_a_straight_edge_are_exact_and_the_gradient_points_to_the_bright_side(angle):
    normal = np.array([math.cos(angle), math.sin(angle)])
    along = np.array([-normal[1], normal[0]])
    middle = np.array([50.37, 44.61])
    corners = middle + 200 * np.array([-along, along, along + normal, normal - along])
    edges = extract_edges(polygon_photo(corners, contrast=60.0, noise=0.0), EdgeSettings())
    inner = np.abs(edges.points - [50, 45]).max(axis=1) < 30
    assert inner.sum() > 40
    assert np.abs((edges.points[inner] - middle) @ normal).max() < 0.02
    directions = edges.gradients[inner] / np.linalg.norm(edges.gradients[inner], axis=1, keepdims=True)
    assert (directions @ normal).min() > 0.999


def test_index_and_points_agree():
    edges = extract_edges(ellipse_photo((50, 45), (25.0, 15.0), 0.4), EdgeSettings())
    columns, rows = np.rint(edges.points).astype(int).T
    np.testing.assert_array_equal(edges.index[rows, columns], np.arange(len(edges.points)))
    assert (edges.index >= 0).sum() == len(edges.points)


@pytest.mark.parametrize('sigma', [0.7, 1.0, 2.5])
def test_a_ramp_has_its_slope_everywhere(sigma):
    y, x = np.indices((60, 70))
    gx, gy = gaussian_gradient((20 + 2 * x + y).astype(np.uint8), sigma)
    np.testing.assert_allclose(gx[10:-10, 10:-10], 2.0, atol=1e-4)
    np.testing.assert_allclose(gy[10:-10, 10:-10], 1.0, atol=1e-4)


def test_noise_is_reduced_as_the_filter_predicts():
    image = np.clip(128 + 10 * np.random.default_rng(0).standard_normal((300, 300)), 0, 255).astype(np.uint8)
    gx, _ = gaussian_gradient(image, 1.5)
    assert gx.std() == pytest.approx(10.0 / (np.sqrt(8.0 * np.pi) * 1.5**2), rel=0.05)


@pytest.mark.parametrize(
    ('image', 'expected'),
    [
        (np.zeros((40, 40)), 'float64'),
        ([[1]], 'list'),
        (np.zeros((40, 40, 3), np.uint8), r'\(40, 40, 3\)'),
        (np.zeros((40, 8), np.uint8), '8 x 40 px'),
    ],
)
def test_refuses_what_is_no_grey_image_in_one_line(image, expected):
    with pytest.raises(StereoLandmarkError, match=expected) as caught:
        extract_edges(image, EdgeSettings())
    assert '\n' not in str(caught.value)
