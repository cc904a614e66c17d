"""Occupied cells of a real kitchen beside OctoMap: every second Kinect depth image is mapped, the others are the truth.

The truth is the mean signed distance along the rays of the images that are not mapped (Curless & Levoy 1996), computed
here with numpy alone. Poses are sure to 1 to 2 cm. The carpet's plane, fitted, is z = 0.
"""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from _figures import Figure, count, rate, time
from _harness import Run, cpu_time, run_benchmark, use_one_core
from _mapping_methods import FIRST_TILE, PYOCTOMAP, Dense, Method, OctoMap, Voxels, dense_shape
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from reward_planner.core.settings import VoxelSettings
from reward_planner.core.voxels.rolling_voxel_grid import TILE_SIZE, SensorView
from scene_simulator.room.box_room import points_from_depth
from shirube_core.geometry import PinholeCamera

CAMERA = PinholeCamera(640, 480, 585.0, 585.0, 320.0, 240.0)
SETTINGS = VoxelSettings()
PERIOD = 1.0 / 6.0
TRUNCATION, VIEWS_MIN = 0.1, 3  # signed distances are cut there [m]; views that a voxel of the truth needs
_UP_MAX, _PLANE = 0.35, 0.015  # the carpet's normal is as near to the camera's up [rad]; points as near are on it [m]


class View(NamedTuple):
    """A depth image [m], NaN where nothing was measured, and the pose of the camera, shape (4, 4)."""

    depth: NDArray[np.float32]
    T_map_camera: NDArray[np.float64]


def kitchen(folder: Path) -> list[View]:
    """Return the images over the carpet's plane, the middle of the first camera's view in the middle of the map."""
    views = []
    for path in sorted(folder.glob('frame-*.depth.png')):
        depth = 0.001 * np.asarray(cv2.imread(str(path), cv2.IMREAD_UNCHANGED), dtype=np.float32)
        depth[depth == 0.0] = np.nan
        T = np.loadtxt(str(path).replace('.depth.png', '.pose.txt'))
        U, _, Vt = np.linalg.svd(T[:3, :3])
        T[:3, :3] = U @ Vt
        views.append(View(depth, T))
    points = np.concatenate([world_points(view)[::199] for view in views])
    up = -views[0].T_map_camera[:3, 1]
    T_level_world = carpet_frame(points[np.isfinite(points).all(axis=1)], up)
    return [View(depth, T_level_world @ T) for depth, T in views]


def world_points(view: View) -> NDArray[np.float64]:
    """Return the points of a view, shape (n, 3) [m]."""
    T = view.T_map_camera
    return points_from_depth(view.depth, CAMERA) @ T[:3, :3].T + T[:3, 3]


def carpet_frame(points: NDArray[np.float64], up: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the transform to the frame whose plane z = 0 is the lowest large plane: RANSAC, then least squares."""
    rng, best = np.random.default_rng(0), np.zeros(len(points), dtype=np.bool_)
    low = points[points @ up < np.quantile(points @ up, 0.2)]
    for _ in range(500):
        a, b, c = low[rng.choice(len(low), 3, replace=False)]
        normal = np.cross(b - a, c - a)
        normal *= np.sign(normal @ up) / max(float(np.linalg.norm(normal)), 1e-9)
        inliers = np.abs((points - a) @ normal) < _PLANE
        if normal @ up > np.cos(_UP_MAX) and inliers.sum() > best.sum():
            best = inliers
    middle = points[best].mean(axis=0)
    normal = np.linalg.svd(points[best] - middle, full_matrices=False)[2][2]
    normal *= np.sign(normal @ up)
    x = np.cross([0.0, 1.0, 0.0], normal)
    R = np.stack([x / np.linalg.norm(x), np.cross(normal, x / np.linalg.norm(x)), normal])
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, -R @ np.array([*points.mean(axis=0)])
    T[2, 3] = -normal @ middle
    return T


def corners_of(views: list[View]) -> NDArray[np.float64]:
    """Return the mean signed distance of each voxel's eight corners to the surface, NaN for too few views [m].

    The shape is (8, *shape of `Dense`).
    """
    shape, s = dense_shape(SETTINGS), SETTINGS.resolution
    origin = np.array([FIRST_TILE * TILE_SIZE * s, FIRST_TILE * TILE_SIZE * s, SETTINGS.height_min])
    lattice = tuple(side + 1 for side in shape)
    corners = origin + s * np.indices(lattice).reshape(3, -1).T
    distance = signed_distances(views, corners).reshape(lattice)
    steps = ((0, -1), (1, None))
    return np.stack([distance[a:b, c:d, e:f] for a, b in steps for c, d in steps for e, f in steps])


def signed_distances(views: list[View], places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean signed distance of places, shape (n, 3), to the surface, NaN for too few views [m]."""
    total, seen = np.zeros(len(places)), np.zeros(len(places))
    for depth, T in views:
        x, y, z = ((places - T[:3, 3]) @ T[:3, :3]).T
        ahead = np.flatnonzero(z > 0.1)
        u = np.rint(CAMERA.fx * x[ahead] / z[ahead] + CAMERA.cx).astype(np.int64)
        v = np.rint(CAMERA.fy * y[ahead] / z[ahead] + CAMERA.cy).astype(np.int64)
        inside = (u >= 0) & (u < CAMERA.width) & (v >= 0) & (v < CAMERA.height)
        index = ahead[inside]
        distance = depth[v[inside], u[inside]] - z[index]
        known = distance > -TRUNCATION
        total[index[known]] += np.minimum(distance[known], TRUNCATION)
        seen[index[known]] += 1
    return np.where(seen >= VIEWS_MIN, total / np.maximum(seen, 1.0), np.nan)


def any_corner(corners: Dense) -> Dense:
    """Return the voxels of which a corner is set, from shape (8, ...)."""
    return np.asarray(corners.any(axis=0))


def flat(voxels: Dense) -> Dense:
    """Return the cells of the floor that have a voxel above."""
    return np.asarray(voxels.any(axis=2))


def main(run: Run) -> None:
    """Map with all methods."""
    use_one_core()
    views = kitchen(run.data('depth_red_kitchen'))
    mapped, others = views[::2], views[1::2]
    distance, reach = corners_of(others), corners_of(mapped)
    surface = any_corner(distance < 0.0) & any_corner(distance > 0.0)
    seen = surface & any_corner(np.isfinite(reach))
    truth = flat(surface), flat(any_corner(np.isfinite(distance))), flat(seen)
    methods: dict[str, Callable[[], Method]] = {
        '`log_odds`': lambda: Voxels(SETTINGS),
        'the paper: `count`, mean over time': lambda: Voxels(VoxelSettings(rule='count')),
    }
    pyoctomap = run.peer(*PYOCTOMAP)
    if pyoctomap is not None:
        methods['pyoctomap, discretised'] = lambda: OctoMap(pyoctomap, SETTINGS)
    heads = 'method | exact precision | within a cell | exact recall | within a cell | ghosts'
    table = run.table('Kitchen (real)', heads, 'CPU ms a frame: median / 95 %')
    for name, make in methods.items():
        method, taken = make(), []
        for k, (depth, T) in enumerate(mapped):
            points = points_from_depth(depth, CAMERA)
            points = points[np.isfinite(points).all(axis=1)]
            taken.append(cpu_time(method.add, PERIOD * k, points, SensorView(T, CAMERA.fx))[1])
        table.add(name, *scores(flat(method.occupied()), *truth), time(taken))


def scores(occupied: Dense, true: Dense, judged: Dense, visible: Dense) -> list[Figure]:
    """Return precision and recall, exact and within a cell, and occupied cells more than two from a true one."""
    found = occupied & judged
    figures = [rate(int((found & each).sum()), int(found.sum())) for each in (true, _widened(true, 1))]
    figures += [rate(int((visible & each).sum()), int(visible.sum())) for each in (occupied, _widened(occupied, 1))]
    return [*figures, count(int((found & ~_widened(true, 2)).sum()), better='lower')]


def _widened(cells: Dense, by: int) -> Dense:
    return np.asarray(binary_dilation(cells, np.ones((3, 3), dtype=np.bool_), by))


if __name__ == '__main__':
    run_benchmark(main)
