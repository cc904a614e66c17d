"""Motion of the robot between two stamps by the buffers of all nodes, against the ground truth of the bags.

Two tables: both stamps between odometry messages, and the later one 0.1 s past the last message, as for an image that
is newer than the odometry. Cells: error of the later position, root mean square / largest [mm].
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from _figures import Figure, error
from _harness import Option, Run, run_benchmark

from floor_localizer.core.settings import TrackerSettings
from floor_localizer.core.survey.odometry_buffer import SurveyOdometry
from floor_localizer.core.tracker import PosePredictor
from pose_arbiter.core.arbiter import OPERATOR, Arbiter
from pose_arbiter.core.kalman_filter import diagonal
from pose_arbiter.core.settings import ArbiterSettings
from reward_planner.core.mapping.mapping_settings import MappingSettings
from reward_planner.core.mapping.pose_buffer import PoseBuffer
from shirube_bags.bag_reader import BagReader
from shirube_bags.trajectory import planar_poses
from shirube_bags.trajectory_files import load_bag_trajectory
from shirube_core.geometry import SE2
from vlc_beacon.core.receiver.odometry_buffer import LampOdometry

BAGS = Path(__file__).parents[1] / 'bags'
STEP = 300_000_000  # shortest time between the two stamps [ns]
AHEAD = 100_000_000  # how far the later stamp is past the last message [ns]
KEPT = 1_000_000_000  # messages given to a buffer: those of this time [ns]
Messages = Sequence[tuple[int, SE2]]


def _tracker(messages: Messages, start: int, end: int) -> SE2 | None:
    predictor = PosePredictor(TrackerSettings())
    for stamp, pose in messages:
        predictor.add_odometry(stamp * 1e-9, pose)
    return predictor.relative_motion(start * 1e-9, end * 1e-9)


def _survey(messages: Messages, start: int, end: int) -> SE2 | None:
    stamps, poses = zip(*messages, strict=True)
    rows = np.array([(pose.x, pose.y, pose.yaw) for pose in poses])
    buffer = SurveyOdometry(np.array(stamps), rows, '/odom')
    return _between(buffer.pose_at(start, 'image'), buffer.pose_at(end, 'image'))


def _lamps(messages: Messages, start: int, end: int) -> SE2 | None:
    buffer = LampOdometry()
    for stamp, pose in messages:
        buffer.add(stamp * 1e-9, pose)
    return _between(buffer.pose_at(start * 1e-9), buffer.pose_at(end * 1e-9))


def _arbiter(messages: Messages, start: int, end: int) -> SE2 | None:
    arbiter = Arbiter([], ArbiterSettings())
    for stamp, pose in messages:
        arbiter.add_odometry(stamp, pose, stamp)
    arbiter.add_pose(OPERATOR, start, SE2(0.0, 0.0, 0.0), diagonal(1e-6, 1e-6), start)
    estimate = arbiter.estimate_at(end)
    return None if estimate is None else estimate.pose


def _planner(messages: Messages, start: int, end: int) -> SE2 | None:
    buffer = PoseBuffer(MappingSettings())
    for stamp, pose in messages:
        buffer.add(stamp * 1e-9, pose)
    return _between(buffer.pose_at(start * 1e-9), buffer.pose_at(end * 1e-9))


def _between(first: object, last: object) -> SE2 | None:
    return first.inverse() @ last if isinstance(first, SE2) and isinstance(last, SE2) else None


USERS = {'tracker': _tracker, 'survey': _survey, 'lamps': _lamps, 'arbiter': _arbiter, 'planner': _planner}


def errors(bag_name: str, thin: int, ahead: int) -> dict[str, list[float | None]]:
    """Return the errors by user [mm]; the buffers know the messages up to ``ahead`` [ns] before the later stamp."""
    with BagReader(BAGS / bag_name) as bag:
        odometry, truth = load_bag_trajectory(bag, '/odom'), load_bag_trajectory(bag, '/ground_truth')
    stamps, true_stamps = odometry.stamps_ns[::thin], truth.stamps_ns
    poses, true_poses = ([SE2(*row) for row in planar_poses(t).tolist()] for t in (odometry, truth))
    poses = poses[::thin]
    found: dict[str, list[float | None]] = {user: [] for user in USERS}
    k = int(np.searchsorted(true_stamps, stamps[0] + 2 * KEPT))
    while (after := int(np.searchsorted(true_stamps, true_stamps[k] + STEP))) < len(true_stamps):
        start, end = int(true_stamps[k]), int(true_stamps[after])
        begin, stop = np.searchsorted(stamps, (end - ahead - KEPT, end - ahead + 1))
        messages = list(zip(stamps[begin:stop].tolist(), poses[begin:stop], strict=True))
        true = true_poses[k].inverse() @ true_poses[after]
        for user, motion_of in USERS.items():
            motion = motion_of(messages, start, end)
            found[user].append(None if motion is None else 1e3 * motion.distance_to(true))
        k = after
    return found


def _figure(found: list[float | None]) -> Figure | str:
    known = [distance for distance in found if distance is not None]
    return error(known) if known else 'none'


def main(run: Run, thin: int) -> None:
    """Compare the buffers on all bags."""
    for title, ahead in (('Between messages', -KEPT // 2), ('0.1 s past the last message', AHEAD)):
        table = run.table(f'{title}, odometry at {50 / thin:g} Hz', 'bag', *(f'{user}, mm' for user in USERS))
        for bag in sorted(path.name for path in BAGS.iterdir() if path.is_dir()):
            table.add(bag, *map(_figure, errors(bag, thin, ahead).values()))


if __name__ == '__main__':
    run_benchmark(main, thin=Option(1, 5, 'keep every n-th odometry message'))
