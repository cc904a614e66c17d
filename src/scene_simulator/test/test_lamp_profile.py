"""The painted faces against ray tracing and against distances to the projected outline."""

import math

import cv2
import numpy as np
import pytest
from scipy.spatial import KDTree

from scene_simulator.ceiling.lamp import CeilingLamp, Disc, LampShape, LedGrid, Rectangle
from scene_simulator.ceiling.lamp_profile import edge_distance, face_homographies, half_edge_distance, lamp_profiles
from scene_simulator.ceiling.lens import SHARP, Blooming
from scene_simulator.imaging.exposure import CameraPose, camera_pose
from shirube_core.geometry import SE2, CameraMount, PinholeCamera
from shirube_core.waveform import steady_light

SHAPES = (Disc(0.05), Rectangle(0.12, 0.07), LedGrid(0.05, 0.004, 4))


def inside(shape: LampShape, points: np.ndarray) -> np.ndarray:
    """Return which points are inside a shape, by its definition."""
    s, t = points.T
    if isinstance(shape, Disc):
        return np.hypot(s, t) < shape.radius
    if isinstance(shape, Rectangle):
        return (np.abs(s) < 0.5 * shape.width) & (np.abs(t) < 0.5 * shape.length)
    leds = (np.arange(shape.count) - 0.5 * (shape.count - 1)) * shape.pitch
    grid = np.stack(np.meshgrid(leds, leds), axis=-1).reshape(-1, 2)
    return KDTree(grid).query(points)[0] < shape.led_radius


@pytest.mark.parametrize('shape', SHAPES)
@pytest.mark.parametrize('side', [0.0, 1.0, -1.0])
def test_distances_are_those_to_the_nearest_points_and_grow_along_their_gradients(
    shape: LampShape, side: float
) -> None:
    fine, step = np.linspace(-0.09, 0.09, 901), 1e-7
    grid = np.stack(np.meshgrid(fine, fine), axis=-1).reshape(-1, 2)
    points = np.random.default_rng(2).uniform(-0.08, 0.08, (300, 2))
    member = inside(shape, grid) & (side * grid[:, 0] <= 0.0)
    to_members, to_others = (KDTree(grid[which]).query(points)[0] for which in (member, ~member))
    arguments = int(shape.kind), shape.sizes

    def at(moved: np.ndarray) -> np.ndarray:
        if side:
            return np.array([half_edge_distance(s, t, *arguments, side) for s, t in moved])
        return np.array([edge_distance(s, t, *arguments) for s, t in moved])

    found = at(points)
    np.testing.assert_allclose(found[:, 0], to_members - to_others, atol=4e-4)
    np.testing.assert_allclose(np.hypot(*found[:, 1:].T), 1.0)
    ahead = [at(points + shift)[:, 0] for shift in ((step, 0.0), (0.0, step))]
    smooth = np.isclose((np.transpose(ahead) - found[:, :1]) / step, found[:, 1:], atol=1e-4).all(axis=1)
    # Not on the ridges inside, to both sides of which the distance falls.
    assert smooth.mean() > 0.95


CAMERA = PinholeCamera(160, 120, 636.4, 630.0, 80.2, 59.1, (-0.25, 0.08, 0.0008, -0.0005, 0.0))
TILTED = CameraMount((0.0, 0.0, 0.0), (0.05, -0.08, 1.2))
POSE = camera_pose(SE2(0.1, -0.15, 0.4), TILTED)
FORWARD_MOUNT = (0.24, -0.32, 2.5)


def rays_of(camera: PinholeCamera) -> np.ndarray:
    v, u = np.mgrid[-1 : camera.height + 1, -1 : camera.width + 1]
    return camera.rays_from_pixels(np.column_stack([u.ravel(), v.ravel()]))[:, :2].reshape(*u.shape, 2)


def homographies_of(lamp: CeilingLamp, pose: CameraPose, rows: int) -> np.ndarray:
    one = face_homographies(lamp.xyz, lamp.rotation, pose.position[None], pose.rotation[None])
    return np.broadcast_to(one, (rows, 3, 3)).copy()


def painted(lamp: CeilingLamp, blooming: Blooming) -> np.ndarray:
    rays = np.ascontiguousarray(rays_of(CAMERA))
    return lamp_profiles(lamp, blooming, rays, homographies_of(lamp, POSE, CAMERA.height))


def distances_to_outline(lamp: CeilingLamp) -> np.ndarray:
    """Signed distances of all pixels from the projected outline [px], by trying all its points."""
    steps = np.linspace(0.0, 1.0, 100, endpoint=False)[:, None]
    outline = lamp.shape.outline()
    dense = np.concatenate([a + steps * (b - a) for a, b in zip(outline, np.roll(outline, -1, 0), strict=True)])
    if isinstance(lamp.shape, Disc):
        dense *= lamp.shape.radius / np.hypot(*dense.T)[:, None]
    line = CAMERA.pixels_from_points(POSE.camera_points(lamp.map_points(dense)))
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    pixels = np.column_stack([u.ravel(), v.ravel()])
    distances = KDTree(line).query(pixels)[0].reshape(u.shape)
    rays = np.vstack([rays_of(CAMERA)[1:-1, 1:-1].reshape(-1, 2).T, np.ones(u.size)])
    face = homographies_of(lamp, POSE, 1)[0] @ rays
    return np.where(inside(lamp.shape, (face[:2] / face[2]).T).reshape(u.shape), -distances, distances)


@pytest.mark.parametrize('shape', [Disc(0.06), Rectangle(0.16, 0.08)])
@pytest.mark.parametrize('blooming', [Blooming(), SHARP])
def test_light_falls_with_the_distance_from_the_outline(shape: LampShape, blooming: Blooming) -> None:
    lamp = CeilingLamp(FORWARD_MOUNT, shape, rpy=(0.0, 0.1, 0.6))
    expected = blooming.profile(distances_to_outline(lamp))
    assert np.abs(painted(lamp, blooming)[0] - expected).max() < 0.03


@pytest.mark.parametrize('shape', [Disc(0.06), LedGrid(0.06), Rectangle(0.16, 0.08)])
def test_both_halves_together_are_the_whole_lamp(shape: LampShape) -> None:
    halves = painted(CeilingLamp(FORWARD_MOUNT, shape, steady_light(2)), Blooming())
    whole = painted(CeilingLamp(FORWARD_MOUNT, shape), Blooming())
    np.testing.assert_allclose(halves.sum(axis=0), whole[0], atol=1e-6)


def test_a_grid_of_leds_is_dark_between_them_when_seen_from_near() -> None:
    lamp = CeilingLamp((0.12, -0.17, 0.35), LedGrid())
    grid = lamp.shape
    assert isinstance(grid, LedGrid)
    light = painted(lamp, SHARP)[0]
    on, between = 0.5 * grid.pitch, grid.pitch
    seen = CAMERA.pixels_from_points(POSE.camera_points(lamp.map_points([(on, on), (between, between)])))
    (u, v), (u_dark, v_dark) = np.rint(seen).astype(int)
    assert light[v, u] > 0.9
    assert light[v_dark, u_dark] < 0.1


def test_a_face_at_a_slant_has_the_area_of_its_projection() -> None:
    lamp = CeilingLamp((0.2, -0.3, 2.0), Disc(0.06), rpy=(math.radians(50.0), 0.0, 0.0))
    outline = CAMERA.pixels_from_points(POSE.camera_points(lamp.map_points(lamp.shape.outline())))
    x, y = outline.T
    area = 0.5 * abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    assert painted(lamp, SHARP).sum() == pytest.approx(area, rel=0.01)


@pytest.mark.parametrize('shape', [Disc(0.0325), LedGrid(0.0325), Rectangle(0.065, 0.065)])
def test_a_half_glows_all_about_the_lamp_and_fades_along_its_axis(shape: LampShape) -> None:
    halves = CeilingLamp(FORWARD_MOUNT, shape, steady_light(2), rpy=(0.0, 0.0, 0.6))
    first, second = painted(halves, Blooming())
    along = np.linspace(-0.12, 0.12, 121)
    u, v = CAMERA.pixels_from_points(POSE.camera_points(halves.map_points(np.column_stack([along, 0.0 * along])))).T
    lit, other = (cv2.remap(half, *np.float32([u, v]), cv2.INTER_LINEAR).ravel() for half in (first, second))
    # 8 px beyond the edge, where eq. (4) is down to gamma, each half gives half of it, on both sides.
    beyond = 0.0325 + 8.0 * 2.5 / 636.4
    for side in (-beyond, beyond):
        np.testing.assert_allclose(np.interp(side, along, lit), 0.5 * Blooming().glow, rtol=0.05)
    assert np.abs(lit - other[::-1]).mean() < 0.01
    assert (np.diff(lit[along > -0.015]) < 0.01).all()
