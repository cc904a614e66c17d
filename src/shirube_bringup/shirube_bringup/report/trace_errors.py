"""Pose errors against ground truth, and the times of the robot in each zone."""

from itertools import pairwise

import numpy as np

from scene_simulator.mission.layout import ZONES
from shirube_bringup.record import Array, MissionTraces, as_array, true_poses
from shirube_core.geometry import SE2


def align_to_map(odometry: Array, truth: Array) -> Array:
    """Return wheel odometry in the map frame, aligned to the true pose at its start; same shape."""
    if not len(odometry):
        return odometry
    start = true_poses(truth, odometry[:1, 0])[0]
    first = odometry[0]
    T_map_odom = SE2(*start[1:].tolist()) @ SE2(*first[1:].tolist()).inverse()
    return np.column_stack([odometry[:, 0], T_map_odom.transform(odometry[:, 1:3]), odometry[:, 3] + T_map_odom.yaw])


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
