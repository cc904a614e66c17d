"""Pose errors against ground truth, and the times of the robot in each zone."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from scene_simulator.mission.layout import ZONES
from shirube_bringup.record import MissionTraces, StampedNumbers
from shirube_core.geometry import SE2

Array = NDArray[np.float64]


def as_array(poses: Sequence[StampedNumbers]) -> Array:
    """Return poses as an array, shape (n, 4): time, x, y, yaw."""
    return np.array(poses, dtype=np.float64).reshape(-1, 4)


def true_poses(truth: Array, times: Array) -> Array:
    """Return the true poses at times, shape (m,) [s], interpolated between those of shape (n, 4), shape (m, 4)."""
    columns = (truth[:, 1], truth[:, 2], np.unwrap(truth[:, 3]))
    return np.column_stack([times, *(np.interp(times, truth[:, 0], column) for column in columns)])


def pose_errors(poses: Array, truth: Array) -> tuple[Array, Array, Array]:
    """Return time [s], position error [m] and yaw error [rad] of each pose that is not before the first true pose."""
    poses = poses[poses[:, 0] >= truth[0, 0]]
    differences = poses - true_poses(truth, poses[:, 0])
    yaw_error = np.remainder(differences[:, 3] + np.pi, 2.0 * np.pi) - np.pi
    return poses[:, 0], np.hypot(differences[:, 1], differences[:, 2]), yaw_error


def align_to_map(odometry: Array, truth: Array) -> Array:
    """Return wheel odometry in the map frame, aligned to the true pose at its start; same shape."""
    if not len(odometry):
        return odometry
    start = true_poses(truth, odometry[:1, 0])[0]
    first = odometry[0]
    T_map_odom = SE2(*start[1:].tolist()) @ SE2(*first[1:].tolist()).inverse()
    moved = [T_map_odom @ SE2(x, y, yaw) for _, x, y, yaw in odometry.tolist()]
    return np.column_stack([odometry[:, 0], np.array([(pose.x, pose.y, pose.yaw) for pose in moved])])


def zone_spans(truth: Array) -> dict[str, list[tuple[float, float]]]:
    """Return the time intervals of the robot in each zone [s], by the zone's name."""
    spans: dict[str, list[tuple[float, float]]] = {}
    for name, zone in ZONES.items():
        inside = [zone.contains(x, y) for _, x, y, _ in truth.tolist()]
        edges = [k for k, (before, after) in enumerate(pairwise([False, *inside, False])) if before != after]
        last = len(truth) - 1
        times = [float(truth[min(k, last), 0]) for k in edges]
        spans[name] = list(zip(times[::2], times[1::2], strict=True))
    return spans


def compute_speeds(truth: Array) -> tuple[Array, Array]:
    """Return times [s] and the true speed [m/s], averaged over 0.2 s."""
    step = 10
    moved = np.hypot(*(truth[step:, 1:3] - truth[:-step, 1:3]).T)
    return (truth[step:, 0] + truth[:-step, 0]) / 2.0, moved / (truth[step:, 0] - truth[:-step, 0])


def align_all_poses(traces: MissionTraces) -> dict[str, Array]:
    """Return the poses of every source in the map frame by name, odometry aligned to the true start."""
    truth = as_array(traces.truth)
    poses = {name: as_array(values) for name, values in traces.poses.items()}
    return {name: align_to_map(values, truth) if name == 'odometry' else values for name, values in poses.items()}


def status_rates(traces: MissionTraces, source: str) -> dict[str, Array]:
    """Return how many poses of a source had each measurement status in each simulated second.

    The arbiter counts in wall time, so more often.
    """
    seconds = np.arange(0.0, np.ceil(traces.truth[-1][0]) + 2.0)
    rates = {}
    for status in sorted({count.verdict for count in traces.trust if count.source == source}):
        counts = [(c.time, c.count) for c in traces.trust if (c.source, c.verdict) == (source, status)]
        times, totals = np.array(counts, dtype=np.float64).T
        rates[status] = np.diff(np.concatenate([[0.0], totals])[np.searchsorted(times, seconds, side='right')])
    return rates
