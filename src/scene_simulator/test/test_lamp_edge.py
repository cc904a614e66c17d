"""Distances to edges against the nearest of many points of the outline."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import KDTree

from scene_simulator.lamp_edge import edge_distance, half_edge_distance
from scene_simulator.lamp_shape import Disc, LampShape, LedGrid, Rectangle

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


def raster_distances(member: np.ndarray, grid: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return signed distances from the border between the members of a fine grid of points and the others."""
    to_members, to_others = (KDTree(grid[which]).query(points)[0] for which in (member, ~member))
    return to_members - to_others


@pytest.mark.parametrize('shape', SHAPES)
@pytest.mark.parametrize('side', [0.0, 1.0, -1.0])
def test_distances_are_those_to_the_nearest_points(shape: LampShape, side: float) -> None:
    fine = np.linspace(-0.09, 0.09, 901)
    grid = np.stack(np.meshgrid(fine, fine), axis=-1).reshape(-1, 2)
    points = np.random.default_rng(2).uniform(-0.08, 0.08, (300, 2))
    member = inside(shape, grid) & (side * grid[:, 0] <= 0.0)
    expected = raster_distances(member, grid, points)
    arguments = int(shape.kind), shape.sizes
    found = [
        half_edge_distance(s, t, *arguments, side) if side else edge_distance(s, t, *arguments)
        for s, t in points
    ]
    np.testing.assert_allclose(np.array(found)[:, 0], expected, atol=4e-4)


@pytest.mark.parametrize('shape', SHAPES)
@pytest.mark.parametrize('side', [0.0, 1.0, -1.0])
def test_gradients_are_unit_vectors_along_which_the_distance_grows(shape: LampShape, side: float) -> None:
    arguments = int(shape.kind), shape.sizes

    def at(s: float, t: float) -> tuple[float, float, float]:
        return half_edge_distance(s, t, *arguments, side) if side else edge_distance(s, t, *arguments)

    step = 1e-7
    smooth = 0
    for s, t in np.random.default_rng(3).uniform(-0.08, 0.08, (200, 2)):
        distance, along_s, along_t = at(s, t)
        assert np.hypot(along_s, along_t) == pytest.approx(1.0)
        slopes = [(at(s + step, t)[0] - distance) / step, (at(s, t + step)[0] - distance) / step]
        # Not on the ridges inside, to both sides of which the distance falls.
        smooth += np.allclose(slopes, [along_s, along_t], atol=1e-4)
    assert smooth > 190
