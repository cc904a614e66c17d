"""The pictures of a corridor are right to a hundredth of a pixel and less: measured on edges and pixel by pixel."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from flat_patches import BRIGHT, GROUND, patches, plain_wall
from numpy.typing import NDArray

from scene_simulator.corridor.fittings import NoticeBoard
from scene_simulator.corridor.instruments import Cabinet
from scene_simulator.corridor.scene import CorridorScene
from scene_simulator.corridor.shapes import RoundLandmark, SquareLandmark, facing_wall
from scene_simulator.corridor.stereo_rig import StereoCamera, StereoOptics
from scene_simulator.imaging.exposure import CameraPose, camera_pose
from scene_simulator.imaging.sensors import GainSensor
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

PLAIN = StereoOptics(vignetting=0.0)
CAMERA = StereoCamera(PinholeCamera(320, 240, 306.0, 305.0, 158.3, 121.1), PLAIN)
BENT = StereoCamera(PinholeCamera(64, 48, 60.0, 61.0, 30.9, 24.2, (-0.28, 0.08, 0.002, -0.001, 0.01)), PLAIN)
LEANING = CameraMount((0.1, 0.12, 1.2), (-math.pi / 2.0 + 0.03, 0.04, -math.pi / 2.0 + 0.02))
POSES = [SE2(-2.6, 0.0, 0.0), SE2(-3.0, 0.4, -0.26), SE2(-2.4, -0.3, 0.2)]


@pytest.fixture(scope='module')
def scene() -> CorridorScene:
    return patches()


def parts_of(scene: CorridorScene) -> tuple[SquareLandmark, RoundLandmark]:
    square, disc = scene.landmarks
    assert isinstance(square, SquareLandmark)
    assert isinstance(disc, RoundLandmark)
    return square, disc


def circle_image(circle: RoundLandmark, camera: PinholeCamera, pose: CameraPose) -> tuple[NDArray[np.float64], ...]:
    """Return centre and semi-axes of the ellipse that is the picture of a circle: H^-T C H^-1 of its conic C [px]."""
    u, v = circle.centre
    origin, right, up = pose.camera_points(circle.surface.points_map([(u, v), (u + 1.0, v), (u, v + 1.0)]))
    plane_from_pixels = np.linalg.inv(camera.matrix @ np.column_stack([right - origin, up - origin, origin]))
    conic = plane_from_pixels.T @ np.diag([1.0, 1.0, -(circle.radius**2)]) @ plane_from_pixels
    centre = -np.linalg.solve(conic[:2, :2], conic[:2, 2])
    value = -(conic[2, 2] + conic[:2, 2] @ centre)
    return centre, np.sqrt(abs(value) / np.linalg.eigvalsh(conic[:2, :2] * math.copysign(1.0, value)))


def moments(
    light: NDArray[np.float64], middle: NDArray[np.float64], reach: float
) -> tuple[float, NDArray[np.float64], NDArray[np.float64]]:
    """Return sum, centroid and covariance of the light within a distance of a pixel."""
    v, u = np.mgrid[: light.shape[0], : light.shape[1]]
    window = np.hypot(u - middle[0], v - middle[1]) < reach
    pixels, weight = np.array([u[window], v[window]]), light[window]
    return weight.sum(), np.average(pixels, axis=1, weights=weight), np.cov(pixels, aweights=weight, ddof=0)


def brightness(light: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return the fraction of the bright paint in each pixel."""
    return (np.asarray(light, dtype=np.float64) - GROUND) / (BRIGHT - GROUND)


@pytest.mark.parametrize('pose', POSES)
@pytest.mark.parametrize('blur', [0.0, 0.6, 1.5])
def test_edges_of_a_panel_are_where_its_corners_project(scene: CorridorScene, pose: SE2, blur: float) -> None:
    T_map_camera = camera_pose(pose, LEANING)
    camera = replace(CAMERA, optics=StereoOptics(blur, vignetting=0.0))
    seen = brightness(camera.light(scene, T_map_camera))
    corners = np.array(list(parts_of(scene)[0].points_map().values()))
    upper_left, upper_right, lower_right, lower_left = CAMERA.intrinsics.pixels_from_points(
        T_map_camera.camera_points(corners)
    )
    rows = np.arange(math.ceil(max(upper_left[1], upper_right[1])) + 8, math.floor(lower_left[1]) - 8)
    middle = int(0.5 * (upper_left[0] + upper_right[0]))
    end = int(max(upper_right[0], lower_right[0])) + 10
    left = middle - 0.5 - seen[rows, :middle].sum(axis=1)
    right = middle - 0.5 + seen[rows, middle:end].sum(axis=1)
    for found, top, bottom in ((left, upper_left, lower_left), (right, upper_right, lower_right)):
        expected = top[0] + (rows - top[1]) / (bottom[1] - top[1]) * (bottom[0] - top[0])
        assert np.abs(found - expected).max() < 0.002


@pytest.mark.parametrize('pose', POSES)
def test_the_outline_of_a_meter_is_the_projected_circle(scene: CorridorScene, pose: SE2) -> None:
    T_map_camera = camera_pose(pose, LEANING)
    disc = parts_of(scene)[1]
    middle, semi_axes = circle_image(disc, CAMERA.intrinsics, T_map_camera)
    seen = brightness(CAMERA.light(scene, T_map_camera))
    area, centre, second = moments(seen, middle, semi_axes[0] + 6.0)
    assert area == pytest.approx(math.pi * semi_axes[0] * semi_axes[1], rel=1e-4)
    np.testing.assert_allclose(centre, middle, atol=0.002)
    # A blur adds its variance and a pixel's square that of its own; an ellipse has a quarter of its squared axes.
    axes = np.sqrt(4.0 * (np.linalg.eigvalsh(second) - PLAIN.blur**2 - 1.0 / 12.0))
    np.testing.assert_allclose(axes[::-1], semi_axes, atol=0.005)


@pytest.mark.parametrize('camera', [BENT, replace(CAMERA, intrinsics=PinholeCamera(64, 48, 60.0, 61.0, 31.0, 24.0))])
def test_each_pixel_is_that_of_many_samples(scene: CorridorScene, camera: StereoCamera) -> None:
    T_map_camera = camera_pose(POSES[1], LEANING)
    seen = camera.light(scene, T_map_camera)
    expected = supersampled(scene, camera, T_map_camera, 24)
    difference = (seen - expected)[3:-3, 3:-3]  # At the border the blur does not know what is outside.
    assert np.abs(difference).max() < 0.013 * (BRIGHT - GROUND)
    assert abs(difference.mean()) < 1e-4


def supersampled(scene: CorridorScene, camera: StereoCamera, pose: CameraPose, samples: int) -> NDArray[np.float64]:
    """Follow the ray of each of many samples of each pixel to the wall."""
    lens = camera.intrinsics
    v, u = (np.mgrid[: lens.height * samples, : lens.width * samples] + 0.5) / samples - 0.5
    directions = lens.rays_from_pixels(np.column_stack([u.ravel(), v.ravel()])) @ pose.rotation.T
    points = pose.position - pose.position[0] / directions[:, :1] * directions
    right, up = -points[:, 1], points[:, 2]
    square, disc = parts_of(scene)
    inside = (square.low[0] < right) & (right < square.high[0]) & (square.low[1] < up) & (up < square.high[1])
    inside |= np.hypot(right - disc.centre[0], up - disc.centre[1]) < disc.radius
    fine = np.where(inside, BRIGHT, GROUND).reshape(u.shape)
    blurred = cv2.GaussianBlur(fine, (0, 0), camera.optics.blur * samples, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(cv2.resize(blurred, (lens.width, lens.height), interpolation=cv2.INTER_AREA))


@pytest.mark.parametrize('pose', POSES)
def test_no_seam_shows_along_the_outline_of_a_box(pose: SE2) -> None:
    """What shines through between two surfaces shrinks with the pixel; so a picture is the mean of a finer one."""
    cabinet = Cabinet('box', facing_wall(0.0), (-0.3, 1.0), depth=0.3)
    scene = plain_wall().with_objects([cabinet, NoticeBoard('board', facing_wall(0.0), (0.5, 0.6))])
    sharp, T_map_camera = (replace(CAMERA, optics=StereoOptics(0.0, vignetting=0.0)), camera_pose(pose, LEANING))
    lens, many = sharp.intrinsics, 4
    cx, cy = ((c + 0.5) * many - 0.5 for c in (lens.cx, lens.cy))
    finer = PinholeCamera(lens.width * many, lens.height * many, lens.fx * many, lens.fy * many, cx, cy)
    fine = replace(sharp, intrinsics=finer).light(scene, T_map_camera)
    mean = cv2.resize(fine, (lens.width, lens.height), interpolation=cv2.INTER_AREA)
    difference = np.abs(sharp.light(scene, T_map_camera) - mean)
    for name, most in (('box', 0.015), ('board', 0.04)):  # The cork behind the board's frame has its grain.
        outline = np.zeros(difference.shape, dtype=np.uint8)
        corners = np.array([scene.points_map()[f'{name}/{index}'] for index in range(4)])
        pixels = lens.pixels_from_points(T_map_camera.camera_points(corners))
        cv2.polylines(outline, [np.rint(pixels).astype(np.int32)], True, (1,), 3)
        assert difference[outline > 0].max() < most


def test_motion_smears_without_moving(scene: CorridorScene) -> None:
    pose = camera_pose(POSES[0], LEANING)
    middle, semi_axes = circle_image(parts_of(scene)[1], CAMERA.intrinsics, pose)
    smeared = replace(CAMERA, optics=StereoOptics(0.6, (3.0, -1.5), 0.0))
    (_, centre, spread), (_, _, sharp) = (
        moments(brightness(taken.light(scene, pose)), middle, semi_axes[0] + 8.0) for taken in (smeared, CAMERA)
    )
    np.testing.assert_allclose(centre, middle, atol=0.002)
    way = np.array([3.0, -1.5])
    # Each instant is shared among neighbouring samples, which adds the variance of a triangle.
    expected = np.outer(way, way) / 12.0 + np.eye(2) / 24.0
    np.testing.assert_allclose(spread - sharp, expected, atol=0.005)


def test_corners_are_darker_and_noise_is_as_the_sensor_says(scene: CorridorScene) -> None:
    pose = camera_pose(POSES[0], LEANING)
    dim = replace(CAMERA, optics=StereoOptics(0.6, vignetting=0.4))
    ratio = dim.light(scene, pose) / CAMERA.light(scene, pose)
    assert ratio[120, 160] == pytest.approx(1.0, abs=1e-3)
    assert ratio[0, 0] == pytest.approx(0.6)
    sensor = GainSensor()
    noise = CAMERA.photograph(scene, pose, np.random.default_rng(1)).astype(float) - CAMERA.photograph(scene, pose)
    expected = math.sqrt(GROUND * sensor.full_well + sensor.read_noise**2) * 255.0 / sensor.full_well
    assert noise[:40].std() == pytest.approx(math.hypot(expected, math.sqrt(1.0 / 12.0)), rel=0.1)


def test_what_is_behind_the_camera_is_not_seen(scene: CorridorScene) -> None:
    away = camera_pose(SE2(-2.0, 0.0, math.pi), LEANING)
    assert not CAMERA.light(scene, away).any()
