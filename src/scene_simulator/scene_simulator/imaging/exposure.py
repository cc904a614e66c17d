"""Exposure of a frame: when each row is exposed, the frame times, and the camera pose meanwhile."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from scene_simulator.errors import SceneError
from shirube_core.geometry import SE2, CameraMount, matrix_from_rpy

_KNOTS = 5  # poses sampled per frame, with linear interpolation between them: at 1 m/s^2 an error of 2 um in 16 ms


@dataclass(frozen=True)
class Shutter:
    """Timing of a camera.

    The stamp of a frame is the time at which its first row starts to collect light; row r starts
    ``r * row_time`` later.

    Attributes:
        exposure: how long each row collects light [s].
        row_time: how much later each row starts than the row above; 0 for a global shutter [s].
    """

    exposure: float = 0.0005
    row_time: float = 0.0

    def __post_init__(self) -> None:
        """Refuse times that no shutter has with a SceneError."""
        if not (0.0 < self.exposure < math.inf and 0.0 <= self.row_time < math.inf):
            raise SceneError(
                f'exposure and row time are {self.exposure} s and {self.row_time} s: '
                'give a positive exposure and a row time of 0 (global shutter) or more'
            )

    def row_middle(self, stamp: float, row: float) -> float:
        """Return the middle of a row's exposure [s]; the row counts from 0 and may be fractional."""
        return stamp + self.row_time * row + 0.5 * self.exposure

    def frame_middle(self, stamp: float, height: int) -> float:
        """Return the middle of the exposure of a frame of ``height`` rows [s]: its pose fits the frame best."""
        return self.row_middle(stamp, 0.5 * (height - 1))

    def frame_end(self, stamp: float, height: int) -> float:
        """Return when the last row of a frame stops collecting light [s]."""
        return stamp + self.row_time * (height - 1) + self.exposure

    def exposure_boundaries(self, stamp: float, rows: slice, count: int) -> NDArray[np.float64]:
        """Return the times that cut each row's exposure into ``count`` equal parts, shape (rows, count + 1) [s].

        The rows are those from ``start`` to before ``stop`` of a frame with a stamp [s].
        """
        starts = stamp + self.row_time * np.arange(rows.start, rows.stop, dtype=np.float64)
        return np.asarray(starts[:, None] + self.exposure * np.arange(count + 1) / count)


@dataclass(frozen=True)
class CameraClock:
    """Frame rate of a camera [1/s], and standard deviation of the stamps from the true starts of the frames [s]."""

    rate: float = 60.0
    stamp_jitter: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what no camera does with a SceneError."""
        if not (0.0 < self.rate < math.inf and 0.0 <= self.stamp_jitter < math.inf):
            raise SceneError(f'the camera has rate {self.rate} and jitter {self.stamp_jitter}: give above 0, 0 or more')

    def frames(self, seconds: float, rng: np.random.Generator) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return true starts and stamps [s], (n,) each, of the first seconds; raise a SceneError if there are none."""
        if not 0.0 < seconds < math.inf:
            raise SceneError(f'the recording is {seconds} s long: give a positive number of seconds')
        starts = np.arange(math.ceil(seconds * self.rate - 1e-9)) / self.rate
        stamps = starts + self.stamp_jitter * rng.standard_normal(len(starts))
        return starts, stamps


@dataclass(frozen=True, eq=False)
class CameraPose:
    """``T_map_camera``: optical centre in the map frame, (3,) [m], and ``R_map_camera``, (3, 3)."""

    position: NDArray[np.float64]
    rotation: NDArray[np.float64]

    def camera_points(self, points: ArrayLike) -> NDArray[np.float64]:
        """Take points, shape (n, 3), from the map frame to the optical frame [m]."""
        return np.asarray((np.asarray(points, dtype=np.float64) - self.position) @ self.rotation)


PoseAt = Callable[[float], CameraPose]  # gives the camera's pose at a time [s]


def camera_pose(T_map_base: SE2, mount: CameraMount) -> CameraPose:
    """Return the pose of a camera on a robot at a pose.

    The mount is in ``base_link`` or, for a robot that sways, in the upright frame under it (``Suspension.mount_at``).
    """
    heading = matrix_from_rpy((0.0, 0.0, T_map_base.yaw))
    position = heading @ np.array(mount.xyz) + (T_map_base.x, T_map_base.y, 0.0)
    return CameraPose(np.asarray(position), heading @ mount.rotation)


class CameraMotion:
    """Camera trajectory during one frame."""

    def __init__(self, pose_at: PoseAt, start: float, stop: float) -> None:
        """Ask for the poses between two times [s]."""
        self._times = np.linspace(start, stop, _KNOTS)
        poses = [pose_at(float(time)) for time in self._times]
        self._positions = np.array([pose.position for pose in poses])
        self._middle = poses[_KNOTS // 2].rotation
        turns = self._middle.T @ np.array([pose.rotation for pose in poses])
        self._turns = Rotation.from_matrix(turns).as_rotvec()

    def poses(self, times: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return positions, shape (n, 3) [m], and ``R_map_camera``, shape (n, 3, 3), at times, shape (n,) [s]."""
        positions, turns = (
            np.column_stack([np.interp(times, self._times, column) for column in knots.T])
            for knots in (self._positions, self._turns)
        )
        return positions, self._middle @ _rotations(turns)

    def pose(self, time: float) -> CameraPose:
        """Return the pose at one time [s]."""
        positions, rotations = self.poses(np.array([time]))
        return CameraPose(positions[0], rotations[0])


def _rotations(turns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return rotation matrices, shape (n, 3, 3), of rotation vectors, shape (n, 3) [rad], by Rodrigues' formula.

    scipy's Rotation is too slow for the few poses that each lamp needs.
    """
    angles = np.linalg.norm(turns, axis=1)[:, None, None]
    cross = np.zeros((len(turns), 3, 3))
    cross[:, [2, 0, 1], [1, 2, 0]] = turns
    cross[:, [1, 2, 0], [2, 0, 1]] = -turns
    half = np.sinc(0.5 * angles / np.pi)
    return np.asarray(np.eye(3) + np.sinc(angles / np.pi) * cross + 0.5 * half**2 * (cross @ cross))
