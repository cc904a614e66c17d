"""The camera model against OpenCV's forward model and its inverse."""

import math

import numpy as np
import pytest

from shirube_core.geometry import PinholeCamera

STRONG_LENS = PinholeCamera(235, 235, 340.0, 338.0, 116.2, 118.1, (-0.3, 0.1, 0.001, -0.002, 0.01))
IDEAL = PinholeCamera(235, 235, 339.44, 339.44, 117.0, 117.0)


@pytest.mark.parametrize('camera', [STRONG_LENS, IDEAL])
def test_projection_undoes_the_rays(camera: PinholeCamera) -> None:
    pixels = np.random.default_rng(1).uniform(0.0, 234.0, (200, 2))
    np.testing.assert_allclose(camera.pixels_from_points(camera.rays_from_pixels(pixels)), pixels, atol=1e-8)


def test_distortion_is_the_published_polynomial() -> None:
    x, y = 0.21, -0.13
    k1, k2, p1, p2, k3 = STRONG_LENS.distortion
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    u = STRONG_LENS.fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + STRONG_LENS.cx
    v = STRONG_LENS.fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + STRONG_LENS.cy
    np.testing.assert_allclose(STRONG_LENS.pixels_from_points([[x, y, 1.0]]), [[u, v]], atol=1e-9)


@pytest.mark.parametrize('bad', [{'fx': 0.0}, {'fy': -1.0}, {'cx': math.nan}, {'width': 0}])
def test_impossible_intrinsics_are_refused(bad: dict[str, float]) -> None:
    good = {'width': 10, 'height': 10, 'fx': 1.0, 'fy': 1.0, 'cx': 5.0, 'cy': 5.0}
    with pytest.raises(ValueError, match=r'size|finite|focal'):
        PinholeCamera(**{**good, **bad})
