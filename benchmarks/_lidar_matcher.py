"""A 2-D lidar scan matcher (point-to-line ICP, robust), and SLAM with it: keyframes matched with those before."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from shirube_core.geometry import SE2

CELL = 0.04  # points of the map in a cell become one [m]
NEIGHBOURS = 0.12  # radius of the neighbours that define the direction of a point's line [m]
POINTS_MIN = 5
THIN = 0.015  # standard deviation across a line, at the most: corners are none [m]
GATES = (0.4,) * 8 + (0.2,) * 8 + (0.1,) * 8 + (0.05,) * 12
"""Points that are farther from the map are left out, step by step [m]."""
SCALE = 0.02  # residuals beyond it count less [m]
KEYFRAME = (0.3, 0.5)  # distance [m] or turn [rad] from all keyframes at which a scan becomes one
SHARE_MIN = 0.3  # of the points that must be near the map at the end


class ScanMatcher:
    """Matches scans with a map."""

    def __init__(self, scans: Iterable[tuple[SE2, NDArray[np.float64]]]) -> None:
        """Make the map of scans, shape (n, 2) in the base frame [m], at known poses."""
        points = np.concatenate([pose.transform(scan) for pose, scan in scans])
        thin = _means_of_cells(points)
        near = cKDTree(points).query_ball_point(thin, NEIGHBOURS)
        lines = [line for line in (_line(points[members]) for members in near) if line is not None]
        self._points, self._normals = np.array(lines).transpose(1, 0, 2)
        self._tree = cKDTree(self._points)

    def match(self, scan: NDArray[np.float64], guess: SE2) -> SE2 | None:
        """Return ``T_map_base`` of a scan, shape (n, 2) in the base frame [m]; None where too few points fit."""
        pose, share = guess, 0.0
        for gate in GATES:
            points = pose.transform(scan)
            distances, nearest = map(np.asarray, self._tree.query(points, distance_upper_bound=gate))
            paired = np.isfinite(distances)
            share = float(paired.mean())
            if share < SHARE_MIN:
                return None
            pose = self._step(pose, points[paired], nearest[paired])
        return pose

    def _step(self, pose: SE2, points: NDArray[np.float64], nearest: NDArray[np.int64]) -> SE2:
        normals = self._normals[nearest]
        residuals = ((points - self._points[nearest]) * normals).sum(axis=1)
        lever = points - [pose.x, pose.y]
        turn = lever[:, 0] * normals[:, 1] - lever[:, 1] * normals[:, 0]
        J = np.column_stack([normals, turn])
        weights = 1.0 / (1.0 + (residuals / SCALE) ** 2)
        normal = J.T @ (weights[:, None] * J) + 1e-9 * np.eye(3)
        x, y, yaw = np.linalg.solve(normal, -J.T @ (weights * residuals)).tolist()
        return SE2(pose.x + x, pose.y + y, pose.yaw + yaw)


class LidarSlam:
    """Tracks scans in the map of its own keyframes, without loop closure; as the start it is given a pose."""

    def __init__(self, start: SE2) -> None:
        """Start without a map at a pose."""
        self._pose, self._keyframes = start, list[tuple[SE2, NDArray[np.float64]]]()
        self._matcher: ScanMatcher | None = None
        self._is_mapping = True

    def restarted(self, start: SE2) -> LidarSlam:
        """Return a localizer in the map as it is now, which does not grow any more."""
        localizer = LidarSlam(start)
        localizer._matcher, localizer._is_mapping = self._matcher, False
        return localizer

    def track(self, motion: SE2, scan: NDArray[np.float64]) -> SE2:
        """Return the pose after a motion by odometry; where the scan does not fit, that of odometry."""
        self._pose = self._pose @ motion
        if self._matcher is not None:
            self._pose = self._matcher.match(scan, self._pose) or self._pose
        if self._is_mapping and all(self._is_far(pose) for pose, _ in self._keyframes):
            self._keyframes.append((self._pose, scan))
            self._matcher = ScanMatcher(self._keyframes)
        return self._pose

    def _is_far(self, keyframe: SE2) -> bool:
        return keyframe.distance_to(self._pose) > KEYFRAME[0] or abs(keyframe.yaw_to(self._pose)) > KEYFRAME[1]


def _means_of_cells(points: NDArray[np.float64]) -> NDArray[np.float64]:
    _, cells, counts = np.unique(np.floor(points / CELL), axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(counts), 2))
    np.add.at(sums, cells.ravel(), points)
    return sums / counts[:, None]


def _line(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Return the middle of points, shape (n, 2), and the direction across their line; None where they form none."""
    if len(points) < POINTS_MIN:
        return None
    variances, directions = np.linalg.eigh(np.cov(points.T))
    return (points.mean(axis=0), directions[:, 0]) if variances[0] < THIN**2 else None
