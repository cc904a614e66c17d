"""Outlines in the picture: where the camera model puts them, and cut at the borders."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from scene_simulator.corridor.scene import project_outline, view_planes
from scene_simulator.floor.dot_floor import polygon_areas
from shirube_core.geometry import PinholeCamera

PLAIN = PinholeCamera(320, 240, 300.0, 310.0, 158.0, 121.0)
BENT = PinholeCamera(320, 240, 300.0, 310.0, 158.0, 121.0, (-0.28, 0.08, 0.001, -0.002, 0.01))
SQUARE = np.array([(-1.0, -0.5, 0.0), (1.0, -0.5, 0.0), (1.0, 0.5, 0.0), (-1.0, 0.5, 0.0)])


def moved(points: NDArray[np.float64], *way: float) -> NDArray[np.float64]:
    return np.asarray(points + np.array(way))


def picture(points: NDArray[np.float64], camera: PinholeCamera, scale: float = 2.0) -> NDArray[np.float64]:
    v, u = np.mgrid[: camera.height, : camera.width]
    rays = camera.rays_from_pixels(np.column_stack([u.ravel(), v.ravel()]))[:, :2]
    lens = np.array([camera.fx, camera.fy, camera.cx, camera.cy, *camera.distortion])
    planes = view_planes(rays.reshape(camera.height, camera.width, 2))
    return np.asarray(project_outline(points, planes, lens, (camera.width, camera.height), scale))


def test_a_shape_in_view_is_projected_as_by_the_camera_model() -> None:
    points = moved(SQUARE, 0.1, 0.2, 4.0)
    expected = 2.0 * (PLAIN.pixels_from_points(points) + 0.5)
    np.testing.assert_allclose(picture(points, PLAIN), expected)


def test_a_lens_bends_the_sides() -> None:
    points = moved(SQUARE, 0.1, 0.2, 2.4)
    seen = picture(points, BENT, 1.0)
    fractions = np.linspace(0.0, 1.0, 2000)[:, None]
    sides = zip(points, np.roll(points, -1, axis=0), strict=True)
    dense = np.concatenate([a + fractions * (b - a) for a, b in sides])
    expected = BENT.pixels_from_points(dense) + 0.5
    apart = np.array([np.hypot(*(expected - corner).T).min() for corner in seen])
    assert apart.max() < 0.1
    lost = abs(polygon_areas(expected[None])[0]) - abs(polygon_areas(seen[None])[0])
    # Chords cut off less than 0.002 px all along the outline.
    assert abs(lost) < 0.002 * np.hypot(*np.diff(expected, axis=0).T).sum()


@pytest.mark.parametrize('camera', [PLAIN, BENT])
def test_a_wall_that_goes_past_the_camera_fills_the_picture(camera: PinholeCamera) -> None:
    floor = np.array([(-50.0, 0.0, -3.0), (50.0, 0.0, -3.0), (50.0, 0.0, 80.0), (-50.0, 0.0, 80.0)])
    seen = picture(moved(floor, 0.0, 1.0, 0.0), PLAIN, 1.0)
    horizon = PLAIN.cy + 0.5 + PLAIN.fy / 80.0
    assert seen[:, 1].min() == pytest.approx(horizon)
    assert abs(polygon_areas(seen[None])[0]) == pytest.approx(320.0 * (240.0 - horizon))
    wall = picture(moved(30.0 * SQUARE, 0.0, 0.0, 5.0), camera, 1.0)
    assert abs(polygon_areas(wall[None])[0]) == pytest.approx(320.0 * 240.0)


@pytest.mark.parametrize('shift', [(0.0, 0.0, -3.0), (9.0, 0.0, 3.0), (0.0, -9.0, 3.0)])
def test_shapes_behind_or_outside_the_view_are_not_in_the_picture(shift: tuple[float, float, float]) -> None:
    assert len(picture(moved(SQUARE, *shift), PLAIN)) == 0
    assert len(picture(moved(SQUARE, *shift), BENT)) == 0


def test_a_shape_across_the_border_is_cut_there() -> None:
    points = moved(SQUARE, PLAIN.width / PLAIN.fx * 2.0, 0.0, 4.0)
    seen = picture(points, PLAIN, 1.0)
    assert math.isclose(seen[:, 0].max(), 320.0)
    whole = PLAIN.pixels_from_points(points) + 0.5
    assert seen[:, 0].min() == pytest.approx(whole[:, 0].min())
    assert (seen[:, 1].min(), seen[:, 1].max()) == pytest.approx((whole[:, 1].min(), whole[:, 1].max()))
