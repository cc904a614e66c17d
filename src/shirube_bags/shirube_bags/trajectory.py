"""Trajectories: stamped 3D poses, and their interpolation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation, Slerp

from shirube_bags.errors import TrajectoryError
from shirube_bags.stamps import NANOSECONDS


@dataclass(frozen=True)
class Trajectory:
    """Poses by rising stamp, (n,) [ns]: positions, (n, 3) [m], unit quaternions x, y, z, w, (n, 4)."""

    stamps_ns: NDArray[np.int64]
    positions: NDArray[np.float64]
    quaternions: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of poses."""
        return len(self.stamps_ns)

    def select(self, mask: NDArray[np.bool_]) -> Trajectory:
        """Return the poses where ``mask``, shape (n,), is true."""
        return Trajectory(self.stamps_ns[mask], self.positions[mask], self.quaternions[mask])


def make_trajectory(stamps_ns: ArrayLike, positions: ArrayLike, quaternions: ArrayLike) -> Trajectory:
    """Validate poses, sort them by stamp [ns] and normalize their quaternions.

    Args:
        stamps_ns: array-like of integers, shape (n,).
        positions: array-like, shape (n, 3) [m].
        quaternions: array-like, shape (n, 4), x, y, z, w.

    Raises:
        TrajectoryError: no poses, different shapes, not finite or not normalized numbers, duplicate stamps.
    """
    stamps = np.asarray(stamps_ns, dtype=np.int64)
    if len(stamps) == 0:
        raise TrajectoryError('the trajectory has no poses; give at least one')
    xyz = np.asarray(positions, dtype=np.float64).reshape(len(stamps), -1)
    xyzw = np.asarray(quaternions, dtype=np.float64).reshape(len(stamps), -1)
    if xyz.shape[1] != 3 or xyzw.shape[1] != 4:
        raise TrajectoryError('positions need x, y, z and quaternions x, y, z, w for each stamp')
    first_malformed = find_malformed_pose(xyz, xyzw)
    if first_malformed is not None:
        raise TrajectoryError(
            f'pose {first_malformed[0] + 1} of {len(stamps)} has {first_malformed[1]}; remove such poses'
        )
    order = np.argsort(stamps, kind='stable')
    stamps, xyz, xyzw = stamps[order], xyz[order], xyzw[order]
    xyzw = xyzw / np.linalg.norm(xyzw, axis=1)[:, None]
    duplicates = np.flatnonzero(np.diff(stamps) == 0)
    if len(duplicates):
        raise TrajectoryError(f'two poses have the stamp {stamps[duplicates[0]]} ns; give one pose per stamp')
    return Trajectory(stamps, xyz, xyzw)


def find_malformed_pose(positions: NDArray[np.float64], quaternions: NDArray[np.float64]) -> tuple[int, str] | None:
    """Return the index of the first malformed pose and its fault, or None.

    Args:
        positions: array, shape (n, 3) [m].
        quaternions: array, shape (n, 4), x, y, z, w; normalized up to rounding.
    """
    finite = np.isfinite(positions).all(axis=1)
    unit = np.abs(np.linalg.norm(quaternions, axis=1) - 1.0) < 0.01
    malformed = np.flatnonzero(np.logical_not(np.logical_and(finite, unit)))
    if len(malformed) == 0:
        return None
    index = int(malformed[0])
    return index, 'a quaternion not of length 1' if np.isfinite(
        positions[index]
    ).all() else 'a position that is not finite'


def planar_trajectory(stamps_ns: ArrayLike, poses: ArrayLike) -> Trajectory:
    """Return a trajectory of poses x [m], y [m], yaw [rad], array-like, shape (n, 3); errors as `make_trajectory`."""
    planar = np.asarray(poses, dtype=np.float64).reshape(-1, 3)
    half, zero = planar[:, 2] / 2.0, np.zeros(len(planar))
    positions = np.column_stack([planar[:, 0], planar[:, 1], zero])
    return make_trajectory(stamps_ns, positions, np.column_stack([zero, zero, np.sin(half), np.cos(half)]))


def can_interpolate(trajectory: Trajectory, stamps_ns: NDArray[np.int64], longest_gap_ns: int) -> NDArray[np.bool_]:
    """Return, shape (m,), whether each stamp [ns] is that of a pose or within a gap of at most ``longest_gap_ns``."""
    known = trajectory.stamps_ns
    after = np.minimum(np.searchsorted(known, stamps_ns, side='left'), len(known) - 1)
    before = np.maximum(np.searchsorted(known, stamps_ns, side='right') - 1, 0)
    inside = (known[before] <= stamps_ns) & (stamps_ns <= known[after])
    mask: NDArray[np.bool_] = inside & (known[after] - known[before] <= longest_gap_ns)
    return mask


def interpolate(trajectory: Trajectory, stamps_ns: NDArray[np.int64]) -> Trajectory:
    """Interpolate at rising stamps [ns], (m,): positions linearly, rotations by slerp; TrajectoryError outside."""
    known = trajectory.stamps_ns
    if len(stamps_ns) and not (known[0] <= stamps_ns[0] and stamps_ns[-1] <= known[-1]):
        raise TrajectoryError('stamps are outside the trajectory; give only stamps within it')
    if len(known) == 1 or len(stamps_ns) == 0:
        return trajectory.select(np.isin(known, stamps_ns))
    # Seconds since the start: a double cannot represent an epoch with nanoseconds.
    times, wanted = (known - known[0]) / NANOSECONDS, (stamps_ns - known[0]) / NANOSECONDS
    positions = np.column_stack([np.interp(wanted, times, axis) for axis in trajectory.positions.T])
    rotations = Slerp(times, Rotation.from_quat(trajectory.quaternions))(wanted)
    return Trajectory(stamps_ns, positions, rotations.as_quat())


def planar_poses(trajectory: Trajectory) -> NDArray[np.float64]:
    """Return x [m], y [m] and yaw [rad] of each pose, shape (n, 3)."""
    yaw = Rotation.from_quat(trajectory.quaternions).as_euler('xyz')[:, 2]
    return np.column_stack([trajectory.positions[:, :2], yaw])
