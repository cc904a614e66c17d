"""Errors of an estimated trajectory against ground truth."""

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
    """Errors of the poses that have ground truth at their stamps.

    Attributes:
        estimate: compared poses, n of them.
        reference: ground truth at the same stamps.
        position: position errors, shape (n,) [m].
        heading: yaw errors about the robot's upward axis, shape (n,) [rad], in [-pi, pi],
            counter-clockwise positive.
        unmatched: number of estimated poses without ground truth.
    """

    estimate: Trajectory
    reference: Trajectory
    position: NDArray[np.float64]
    heading: NDArray[np.float64]
    unmatched: int


@dataclass(frozen=True)
class ErrorStatistics:
    """Statistics of absolute errors, in their unit: median, root mean square, 95 % quantile, maximum."""

    median: float
    rms: float
    p95: float
    max: float


def compare_trajectories(estimate: Trajectory, reference: Trajectory, longest_gap: float) -> TrajectoryErrors:
    """Compare an estimate with the reference, which is interpolated at the estimate's stamps.

    There is no alignment: both are poses in the same map frame. A rigid motion of both changes no error.

    Args:
        estimate: estimated poses.
        reference: ground truth.
        longest_gap: longest gap in the ground truth that is interpolated [s].

    Raises:
        TrajectoryError: the two have no stamps in common.
    """
    known = can_interpolate(reference, estimate.stamps_ns, round(longest_gap * NANOSECONDS))
    if not known.any():
        raise TrajectoryError(
            f'the estimate ({time_span(estimate)}) and the reference ({time_span(reference)}) have no stamps '
            'in common; check that both are of the same drive and stamped with the time of the images'
        )
    compared = estimate.select(known)
    truth = interpolate(reference, compared.stamps_ns)
    position = np.linalg.norm(compared.positions - truth.positions, axis=1)
    rotation_error = Rotation.from_quat(truth.quaternions).inv() * Rotation.from_quat(compared.quaternions)
    heading = rotation_error.as_euler('xyz')[:, 2]
    return TrajectoryErrors(compared, truth, position, heading, int(len(estimate) - len(compared)))


def error_statistics(errors: NDArray[np.float64]) -> ErrorStatistics:
    """Return the statistics of errors, shape (n,) with n > 0."""
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
