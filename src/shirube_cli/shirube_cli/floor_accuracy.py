"""Compares a replay of a recorded drive with the drive's ground truth."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shirube_bags.accuracy_report import AccuracyReport, make_report
from shirube_bags.bag_reader import BagReader
from shirube_bags.bag_trajectory import load_bag_trajectory, load_header_stamps
from shirube_bags.coverage import compute_coverage
from shirube_bags.trajectory import Trajectory
from shirube_bags.trajectory_errors import TrajectoryErrors, compare_trajectories
from shirube_cli.floor_replay import IMAGES, FloorReplay

LONGEST_GAP = 0.5
STAMP_TOLERANCE_NS = 1_000_000


@dataclass(frozen=True)
class FloorAccuracy:
    """A replay and its truth.

    Attributes:
        truth: the true poses.
        images_ns: array of int64, shape (n,), stamps of all images [ns].
        dirty_ns: array of int64, shape (k, 2), first and last image of each stretch of hidden floor [ns].
        errors: errors of the poses.
        report: their figures.
    """

    truth: Trajectory
    images_ns: NDArray[np.int64]
    dirty_ns: NDArray[np.int64]
    errors: TrajectoryErrors
    report: AccuracyReport


def measure_accuracy(replay: FloorReplay, bag_path: Path) -> FloorAccuracy:
    """Compare the replay's poses with the truth in the bag.

    Raises:
        ShirubeBagsError: the bag has no truth, no images, or is of another drive.
    """
    with BagReader(bag_path) as bag:
        truth = load_bag_trajectory(bag, '/ground_truth')
        images = load_header_stamps(bag, IMAGES)
        dirt = [(message.stamp_ns, bag.decode(message).data) for message in bag.messages(['/dirt'])]
    dirty = dirty_stretches(dirt)
    errors = compare_trajectories(replay.trajectory, truth, LONGEST_GAP)
    coverage = compute_coverage(images, replay.trajectory.stamps_ns, STAMP_TOLERANCE_NS, dirty)
    return FloorAccuracy(truth, images, dirty, errors, make_report(errors, coverage, 'the images'))


def dirty_stretches(dirt: list[tuple[int, bool]]) -> NDArray[np.int64]:
    """Join images of hidden floor that follow each other.

    Args:
        dirt: stamp [ns] of each image and whether dirt hides the floor in it, in the order of time.

    Returns:
        array of int64, shape (k, 2), first and last such image of each stretch [ns].
    """
    stamps = np.array([stamp for stamp, _ in dirt], dtype=np.int64)
    hidden = np.array([False, *(is_hidden for _, is_hidden in dirt), False])
    starts = np.flatnonzero(~hidden[:-1] & hidden[1:])
    ends = np.flatnonzero(hidden[:-1] & ~hidden[1:]) - 1
    return np.column_stack([stamps[starts], stamps[ends]])
