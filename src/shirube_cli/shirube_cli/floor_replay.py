"""Replays a recorded drive through the live floor localizer and compares it with the ground truth."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shirube_bags.accuracy import AccuracyReport, TrajectoryErrors, compare_trajectories, compute_coverage, make_report
from shirube_bags.bag_reader import BagReader
from shirube_bags.stamps import NANOSECONDS
from shirube_bags.trajectory import Trajectory, make_trajectory
from shirube_bags.trajectory_files import load_bag_trajectory, load_header_stamps
from shirube_cli.live_localizer import PoseListener, live_localizer
from shirube_cli.project import CommandError

LOCALIZER = 'floor_localizer'
IMAGES = '/image_raw/compressed'


@dataclass(frozen=True)
class FloorReplay:
    """What came of a replay: the published poses, the number of images, the delays from an image to its
    pose, shape (n,) [s], the wall time from the first image to the last pose [s], and how many images had
    no pose for which reason.
    """

    trajectory: Trajectory
    images: int
    delays: NDArray[np.float64]
    duration: float
    reasons: dict[str, int]


def replay_floor_drive(root: Path, bag: Path, folder: Path, node_command: list[str] | None = None) -> FloorReplay:
    """Replay the bag as fast as the node keeps up; logs go to the folder.

    The node is the installed one without arguments, unless a command is given. Raises a CommandError if a process
    failed, or no pose came; the message names the log.
    """
    with live_localizer(root, LOCALIZER, IMAGES, folder, node_command) as live:
        live.play(bag, ['--rate', '0'])
        live.listen_for_diagnostics()
        live.end()
    if not live.listener.published:
        raise CommandError(f'the node published no pose; see {live.log}')
    return _sum_up(live.listener)


def _sum_up(listener: PoseListener) -> FloorReplay:
    stamps = sorted(listener.published)
    times = [*listener.images.values(), *listener.published.values()]
    return FloorReplay(
        trajectory=make_trajectory(
            stamps, [listener.positions[stamp] for stamp in stamps], [listener.quaternions[stamp] for stamp in stamps]
        ),
        images=len(listener.images),
        delays=np.array(listener.delays) / NANOSECONDS,
        duration=(max(times) - min(times)) / NANOSECONDS,
        reasons=listener.reasons(),
    )


LONGEST_GAP = 0.5
STAMP_TOLERANCE_NS = 1_000_000


@dataclass(frozen=True)
class FloorAccuracy:
    """A replay and its truth: stamps of all images, shape (n,) [ns], first and last stamp of each stretch of
    hidden floor, shape (k, 2) [ns], and the errors of the poses with their report.
    """

    truth: Trajectory
    images_ns: NDArray[np.int64]
    dirty_ns: NDArray[np.int64]
    errors: TrajectoryErrors
    report: AccuracyReport


def measure_accuracy(replay: FloorReplay, bag_path: Path) -> FloorAccuracy:
    """Compare the replay's poses with the truth in the bag."""
    with BagReader(bag_path) as bag:
        truth = load_bag_trajectory(bag, '/ground_truth')
        images = load_header_stamps(bag, IMAGES)
        dirt = [(message.stamp_ns, bag.decode(message).data) for message in bag.messages(['/dirt'])]
    dirty = dirty_stretches(dirt)
    errors = compare_trajectories(replay.trajectory, truth, LONGEST_GAP)
    coverage = compute_coverage(images, replay.trajectory.stamps_ns, STAMP_TOLERANCE_NS, dirty)
    return FloorAccuracy(truth, images, dirty, errors, make_report(errors, coverage, 'the images'))


def dirty_stretches(dirt: list[tuple[int, bool]]) -> NDArray[np.int64]:
    """Return the first and last stamp [ns], shape (k, 2), of each run of images of hidden floor.

    Args:
        dirt: stamp [ns] of each image and whether dirt hides the floor in it, in the order of time.
    """
    stamps = np.array([stamp for stamp, _ in dirt], dtype=np.int64)
    hidden = np.array([False, *(is_hidden for _, is_hidden in dirt), False])
    starts = np.flatnonzero(~hidden[:-1] & hidden[1:])
    ends = np.flatnonzero(hidden[:-1] & ~hidden[1:]) - 1
    return np.column_stack([stamps[starts], stamps[ends]])
