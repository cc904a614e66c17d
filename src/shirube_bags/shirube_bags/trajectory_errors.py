"""How far an estimated trajectory is from the true one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from shirube_bags.errors import TrajectoryError
from shirube_bags.stamps import NANOSECONDS
from shirube_bags.trajectory import Trajectory, can_interpolate, interpolate


@dataclass(frozen=True)
class TrajectoryErrors:
    """The errors of the poses that could be compared.

    Attributes:
        estimate: the poses that were compared, n of them.
        reference: the true poses at the same stamps.
        position: array, shape (n,), distance from the true position [m].
        heading: array, shape (n,), turn about the robot's own upward axis from the true heading [rad],
            in [-pi, pi], counter-clockwise positive.
        unmatched: poses of the estimate at stamps at which the reference is unknown.
    """

    estimate: Trajectory
    reference: Trajectory
    position: NDArray[np.float64]
    heading: NDArray[np.float64]
    unmatched: int


@dataclass(frozen=True)
class ErrorStatistics:
    """Statistics of the sizes of errors, in their unit: median, root mean square, 95 % quantile, maximum."""

    median: float
    rms: float
    p95: float
    max: float


def compare_trajectories(estimate: Trajectory, reference: Trajectory, longest_gap: float) -> TrajectoryErrors:
    """Compare an estimate with the reference, which is interpolated at the estimate's stamps.

    Nothing is aligned: both are poses in the same map frame. A rigid motion of both changes no error.

    Args:
        estimate: the poses to judge.
        reference: the true poses.
        longest_gap: between two true poses further apart than this nothing is compared [s].

    Raises:
        TrajectoryError: the two have no time in common.
    """
    known = can_interpolate(reference, estimate.stamps_ns, round(longest_gap * NANOSECONDS))
    if not known.any():
        raise TrajectoryError(
            f'the estimate ({time_span(estimate)}) and the reference ({time_span(reference)}) have no stamps '
            'in common; check that they are of the same drive and both stamped with the time of the images'
        )
    judged = estimate.selected(known)
    truth = interpolate(reference, judged.stamps_ns)
    position = np.linalg.norm(judged.positions - truth.positions, axis=1)
    turn = Rotation.from_quat(truth.quaternions).inv() * Rotation.from_quat(judged.quaternions)
    heading = turn.as_euler('xyz')[:, 2]
    return TrajectoryErrors(judged, truth, position, heading, int(len(estimate) - len(judged)))


def error_statistics(errors: NDArray[np.float64]) -> ErrorStatistics:
    """Return the statistics of the sizes of errors, shape (n,) with n > 0."""
    sizes = np.abs(errors)
    return ErrorStatistics(
        median=float(np.median(sizes)),
        rms=float(np.sqrt(np.mean(sizes**2))),
        p95=float(np.quantile(sizes, 0.95)),
        max=float(sizes.max()),
    )


def time_span(trajectory: Trajectory) -> str:
    """Return the first and the last stamp as text, in seconds."""
    first, last = (int(stamp) / NANOSECONDS for stamp in trajectory.stamps_ns[[0, -1]])
    return f'{first:.3f} s to {last:.3f} s'
