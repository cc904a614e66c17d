"""The camera model against OpenCV's forward model and its inverse."""

import math

import numpy as np
import pytest

from shirube_core.geometry import CameraMount, PinholeCamera

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


@pytest.mark.parametrize(
    'bad',
    [{'fx': 0.0}, {'fy': -1.0}, {'cx': math.nan}, {'width': 0}],
)
def test_impossible_intrinsics_are_refused(bad: dict[str, float]) -> None:
    good = {'width': 10, 'height': 10, 'fx': 1.0, 'fy': 1.0, 'cx': 5.0, 'cy': 5.0}
    with pytest.raises(ValueError, match=r'size|finite|focal'):
        PinholeCamera(**{**good, **bad})


def test_the_default_mount_has_the_image_top_ahead_and_the_image_left_on_the_left() -> None:
    mount = CameraMount()
    top_and_left = IDEAL.rays_from_pixels([[117.0, 0.0], [0.0, 117.0]])
    top, left = mount.floor_points_from_rays(top_and_left)
    assert top[0] > 0.04
    assert top[1] == pytest.approx(0.0, abs=1e-12)
    assert left[0] == pytest.approx(0.0, abs=1e-12)
    assert left[1] > 0.04


def test_floor_points_go_to_the_camera_and_back() -> None:
    mount = CameraMount(xyz=(0.1, -0.05, 0.2), rpy=(math.pi + 0.03, -0.02, 1.0))
    floor = np.random.default_rng(2).uniform(-0.1, 0.1, (50, 2))
    rays = mount.camera_points_from_floor(floor)
    np.testing.assert_allclose(mount.floor_points_from_rays(rays), floor, atol=1e-12)


def test_a_ray_that_goes_up_meets_no_floor() -> None:
    assert np.isnan(CameraMount().floor_points_from_rays([[0.0, 0.0, -1.0]])).all()
