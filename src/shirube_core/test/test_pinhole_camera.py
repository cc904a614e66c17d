"""The camera model against OpenCV's forward model and its inverse."""

import math

import cv2
import numpy as np
import pytest

from shirube_core.geometry import LensModel, PinholeCamera, matrix_from_rpy

STRONG_LENS = PinholeCamera(235, 235, 340.0, 338.0, 116.2, 118.1, (-0.3, 0.1, 0.001, -0.002, 0.01))
IDEAL = PinholeCamera(235, 235, 339.44, 339.44, 117.0, 117.0)
# As published by drivers of depth cameras: eight numbers, of which the single ones are large.
RATIONAL = (0.45, -2.7, 0.0006, -0.0003, 1.55, 0.33, -2.5, 1.47)
PRISM, TILT = (0.001, -0.0005, -0.0008, 0.0004), (0.01, -0.02)
FISHEYE = (-0.012, 0.021, -0.018, 0.004)
POLYNOMIAL, EQUIDISTANT = LensModel.RATIONAL_POLYNOMIAL, LensModel.EQUIDISTANT
WIDE = PinholeCamera(640, 480, 280.0, 281.0, 322.0, 238.0, FISHEYE, EQUIDISTANT)
LENSES = [
    IDEAL,
    STRONG_LENS,
    PinholeCamera(640, 480, 505.0, 505.0, 322.0, 238.0, RATIONAL, POLYNOMIAL),
    PinholeCamera(640, 480, 505.0, 505.0, 322.0, 238.0, (*RATIONAL, *PRISM), POLYNOMIAL),
    PinholeCamera(640, 480, 505.0, 505.0, 322.0, 238.0, (*RATIONAL, *PRISM, *TILT), POLYNOMIAL),
    # OpenCV's own inverse of this lens of 120 degrees diverges at the corners.
    PinholeCamera(640, 480, 360.0, 360.0, 322.0, 238.0, (-0.25, 0.06, 0.0005, -0.0005, -0.006)),
    WIDE,
]


@pytest.mark.parametrize('camera', LENSES)
def test_projection_undoes_the_rays(camera: PinholeCamera) -> None:
    u, v = np.meshgrid(np.linspace(0.0, camera.width - 1.0, 15), np.linspace(0.0, camera.height - 1.0, 11))
    pixels = np.column_stack([u.ravel(), v.ravel()])
    np.testing.assert_allclose(camera.pixels_from_points(camera.rays_from_pixels(pixels)), pixels, atol=1e-6)


@pytest.mark.parametrize('camera', LENSES)
def test_pixels_are_those_of_opencv(camera: PinholeCamera) -> None:
    points = np.random.default_rng(3).uniform((-0.5, -0.4, 0.8), (0.5, 0.4, 1.5), (50, 3))
    project = cv2.fisheye.projectPoints if camera.model is EQUIDISTANT else cv2.projectPoints
    args = (camera.matrix, np.array(camera.distortion))
    if camera.model is EQUIDISTANT:
        expected, _ = project(points[:, None], np.zeros(3), np.zeros(3), *args)
    else:
        expected, _ = project(points, np.zeros(3), np.zeros(3), *args)
    np.testing.assert_allclose(camera.pixels_from_points(points), expected.reshape(-1, 2), atol=1e-9)


def test_there_is_no_ray_and_no_pixel_beyond_the_valid_range() -> None:
    folding = PinholeCamera(640, 480, 250.0, 250.0, 320.0, 240.0, (-0.2, 0.0, 0.0, 0.0, 0.0))
    r_max = math.sqrt(1.0 / 0.6)  # r (1 - 0.2 r^2) is largest there
    edge = 320.0 + 250.0 * r_max * (1.0 - 0.2 * r_max**2)
    rays = folding.rays_from_pixels([[edge - 0.5, 240.0], [edge + 0.5, 240.0]])
    assert r_max - 0.1 < rays[0, 0] < r_max
    assert np.isnan(rays[1, :2]).all()
    points = [[0.99 * r_max, 0.0, 1.0], [1.01 * r_max, 0.0, 1.0], [0.1, 0.0, -1.0], [0.0, 0.0, 0.0]]
    assert np.isfinite(folding.pixels_from_points(points)).all(axis=1).tolist() == [True, False, False, False]
    # r (1 - 0.6 r^2 + 0.15 r^4) grows again farther out, where the lens is not as the polynomial says.
    regrowing = PinholeCamera(640, 480, 250.0, 250.0, 320.0, 240.0, (-0.6, 0.15, 0.0, 0.0, 0.0))
    u = np.linspace(320.0, 639.0, 100)
    radii = regrowing.rays_from_pixels(np.column_stack([u, np.full(100, 240.0)]))[:, 0]
    assert np.nanmax(radii) < math.sqrt((1.8 - math.sqrt(1.8**2 - 3.0)) / 1.5)
    assert np.isnan(radii).mean() > 0.4
    # A fisheye lens of more than 180 degrees has no rays with z > 0 at the edge of its image.
    assert np.isnan(WIDE.rays_from_pixels([[322.0 + 280.0 * 1.7, 238.0]])[0, 0])


@pytest.mark.parametrize('camera', LENSES)
def test_rectification_maps_are_the_pixels_of_the_rectified_rays(camera: PinholeCamera) -> None:
    R, matrix = matrix_from_rpy((0.01, -0.02, 0.005)), np.diag([0.8, 0.8, 1.0]) @ camera.matrix
    u, v = camera.rectification_maps(R, matrix)
    assert u.shape == v.shape == (camera.height, camera.width)
    assert np.isfinite(u).all()
    assert np.isfinite(v).all()
    make = cv2.fisheye if camera.model is EQUIDISTANT else cv2
    size = (camera.width, camera.height)
    expected = make.initUndistortRectifyMap(camera.matrix, np.array(camera.distortion), R, matrix, size, cv2.CV_32FC1)
    middle = np.s_[camera.height // 4 : -camera.height // 4, camera.width // 4 : -camera.width // 4]
    np.testing.assert_allclose(u[middle], expected[0][middle], atol=1e-3)
    np.testing.assert_allclose(v[middle], expected[1][middle], atol=1e-3)


def test_distortion_is_the_published_polynomial() -> None:
    x, y = 0.21, -0.13
    k1, k2, p1, p2, k3 = STRONG_LENS.distortion
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    u = STRONG_LENS.fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + STRONG_LENS.cx
    v = STRONG_LENS.fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + STRONG_LENS.cy
    np.testing.assert_allclose(STRONG_LENS.pixels_from_points([[x, y, 1.0]]), [[u, v]], atol=1e-9)


@pytest.mark.parametrize('bad', [{'fx': 0.0}, {'fy': -1.0}, {'cx': math.nan}, {'width': 0}, {'distortion': (0.0,) * 8}])
def test_impossible_intrinsics_are_refused(bad: dict[str, float]) -> None:
    good = {'width': 10, 'height': 10, 'fx': 1.0, 'fy': 1.0, 'cx': 5.0, 'cy': 5.0}
    with pytest.raises(ValueError, match=r'size|finite|focal|8 numbers instead of'):
        PinholeCamera(**{**good, **bad})
