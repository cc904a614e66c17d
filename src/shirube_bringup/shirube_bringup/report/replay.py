"""Data of the replay in the report: poses and people at 10 Hz, and the status of each source per second."""

from typing import Any

import numpy as np

from scene_simulator.mission.layout import ROBOT_RADIUS, ROOM, ZONES
from shirube_bringup.record import Array, MissionTraces, as_array
from shirube_bringup.report.trace_errors import align_all_poses, status_rates

_PERIOD = 0.1  # period of the replay [s]
SOURCES = ('floor_localizer', 'vlc_beacon', 'stereo_landmark')


def replay_data(traces: MissionTraces) -> dict[str, Any]:
    """Return what the page replays, as JSON data; times in s, lengths in m, angles in rad."""
    truth = as_array(traces.truth)
    steps = thin(truth)
    layout = traces.layout
    return {
        'end': float(truth[-1, 0]),
        'radius': ROBOT_RADIUS,
        'room': [*ROOM[:2], *ROOM[3:5]],
        'zones': [[name, zone.low, zone.high] for name, zone in ZONES.items()],
        'boxes': [[x0, y0, x1, y1] for x0, y0, _, x1, y1, _ in traces.boxes],
        'stops': [[pose.x, pose.y, pose.yaw] for pose in (layout.start, *layout.goals)],
        'legs': traces.legs,
        'truth': _rounded(truth[steps]),
        'people': [np.round(traces.people[k], 2).tolist() for k in steps] if traces.people else [],
        'poses': {name: _rounded(poses[thin(poses)]) for name, poses in align_all_poses(traces).items()},
        'status': main_status(traces),
    }


def thin(poses: Array) -> list[int]:
    """Return the indices of the first pose in each period of 0.1 s, shape (n, 4)."""
    return np.unique(np.floor(poses[:, 0] / _PERIOD + 1e-6), return_index=True)[1].tolist()


def _rounded(poses: Array) -> list[list[float]]:
    return [[round(t, 2), round(x, 3), round(y, 3), round(yaw, 3)] for t, x, y, yaw in poses.tolist()]


def main_status(traces: MissionTraces) -> dict[str, list[str]]:
    """Return the status of most poses of each source in each second, empty without poses."""
    seconds = int(np.ceil(traces.truth[-1][0])) + 1
    statuses = {}
    for source in SOURCES:
        rates = status_rates(traces, source)
        statuses[source] = [_largest({name: rate[k] for name, rate in rates.items()}) for k in range(seconds)]
    return statuses


def _largest(rates: dict[str, float]) -> str:
    name = max(rates, key=lambda name: rates[name], default='')
    return name if rates.get(name) else ''
