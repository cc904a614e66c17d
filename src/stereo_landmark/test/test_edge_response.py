import math

import numpy as np
import pytest
from antialiased_shapes import coverage, polygon_intervals

from stereo_landmark.core.primitives.edge_response import (
    BLURS,
    REACH,
    edge_response,
    interpolate_response,
    response_table,
)


@pytest.mark.parametrize('blur', [0.5, 1.0, 2.0])
@pytest.mark.parametrize('angle', [0.0, 0.3, math.pi / 4])
def test_is_what_drawn_pixels_show(blur, angle):
    cos, sin = math.cos(angle), math.sin(angle)
    normal, along = np.array([[cos, sin], [-sin, cos]])
    middle = np.array([30.3, 29.6])
    corners = middle + 200 * np.array([-along, along, along + normal, normal - along])
    drawn = coverage(polygon_intervals(corners), (60, 60), blur)[25:35, 22:38]
    y, x = np.indices(drawn.shape) + np.array([25, 22])[:, None, None]
    distances = (np.stack([x, y], axis=-1) - middle).reshape(-1, 2) @ normal
    np.testing.assert_allclose(edge_response(distances, blur, angle)[:, 0], drawn.ravel(), atol=4e-3)


def test_derivatives_are_what_differences_say():
    d = np.linspace(-4, 4, 33)
    values = edge_response(d, 0.8, 0.4)
    slope = (edge_response(d + 1e-5, 0.8, 0.4) - edge_response(d - 1e-5, 0.8, 0.4))[:, 0] / 2e-5
    growth = (edge_response(d, 0.8 + 1e-5, 0.4) - edge_response(d, 0.8 - 1e-5, 0.4))[:, 0] / 2e-5
    np.testing.assert_allclose(values[:, 1], slope, atol=1e-6)
    np.testing.assert_allclose(values[:, 2], growth, atol=1e-6)


def test_goes_from_nothing_to_everything_and_is_symmetric():
    for blur in (BLURS[0], 1.0):
        values = edge_response(np.array([-8.0, -0.3, 0.0, 0.3, 8.0]), blur, 0.2)[:, 0]
        np.testing.assert_allclose(values[[0, 2, 4]], [0.0, 0.5, 1.0], atol=1e-6)
        assert values[1] + values[3] == pytest.approx(1.0, abs=1e-6)


def test_table_is_looked_up_between_its_places():
    response = np.empty(3)
    for distance in (-2.013, 0.021, 1.777, 0.999 * REACH):
        interpolate_response(response_table()[15, 3], distance, response)
        exact = edge_response(np.array([distance]), BLURS[15], math.pi / 8)[0]
        np.testing.assert_allclose(response, exact, atol=1e-3)
