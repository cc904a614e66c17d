"""``check``: compare poses with ground truth; fail if an error exceeds its limit."""

import argparse
import csv
import json
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shirube_bags.accuracy import (
    COVERAGE,
    STATISTICS,
    AccuracyReport,
    TrajectoryErrors,
    compare_trajectories,
    compute_coverage,
    exceeded_limits,
    format_report,
    make_report,
    report_to_dict,
)
from shirube_bags.bag_reader import BagReader
from shirube_bags.errors import ShirubeBagsError, TrajectoryError
from shirube_bags.stamps import number_from_zero, stamp_from_text, text_from_stamp
from shirube_bags.trajectory import Trajectory, planar_poses
from shirube_bags.trajectory_files import load_bag_trajectory, load_header_stamps, load_tum, save_tum
from shirube_core.command import run_command
from shirube_core.files import write_csv, write_text

# A pose has the stamp of its image; files of other tools round it to microseconds.
STAMP_TOLERANCE_NS = 1_000_000


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 if a limit is exceeded or a file is invalid."""
    options = make_parser().parse_args(arguments)
    return run_command('check', lambda: check_and_print(options), (ShirubeBagsError,))


def check_and_print(options: argparse.Namespace) -> int:
    """Print the report and each exceeded limit; return 1 if there is one."""
    report = check(options)
    print(format_report(report))
    exceeded = exceeded_limits(report, get_limits(options))
    for line in exceeded:
        print(f'check: {line}', file=sys.stderr)
    return 1 if exceeded else 0


def check(options: argparse.Namespace) -> AccuracyReport:
    """Compare the trajectories, write the requested files and return the report."""
    estimate = load_trajectory(options.estimate, options.topic)
    reference_path = options.reference or options.estimate
    reference = load_trajectory(reference_path, options.reference_topic)
    errors = compare_trajectories(estimate, reference, options.longest_gap)
    expected, expected_from = reference.stamps_ns, 'the reference'
    if options.images is not None:
        expected, expected_from = load_image_stamps(reference_path, options.images), options.images
    excluded = load_intervals(options.exclude) if options.exclude else np.empty((0, 2), dtype=np.int64)
    coverage = compute_coverage(expected, estimate.stamps_ns, STAMP_TOLERANCE_NS, excluded)
    report = make_report(errors, coverage, expected_from)
    write_files(options, errors, report)
    return report


def load_trajectory(path: Path, topic: str | None) -> Trajectory:
    """Load a trajectory from a bag's topic or a TUM file."""
    if is_bag(path):
        with BagReader(path) as bag:
            return load_bag_trajectory(bag, topic)
    return load_tum(path)


def load_image_stamps(path: Path, topic: str) -> NDArray[np.int64]:
    """Load the stamps of the images in the bag of the reference."""
    if not is_bag(path):
        raise ShirubeBagsError(f'{path}: is not a bag, so it has no topic {topic}; omit --images')
    with BagReader(path) as bag:
        return load_header_stamps(bag, topic)


def is_bag(path: Path) -> bool:
    """Return whether a path is a bag, not a TUM file, by its name."""
    return path.is_dir() or path.suffix in {'.mcap', '.db3', '.bag'}


def write_files(options: argparse.Namespace, errors: TrajectoryErrors, report: AccuracyReport) -> None:
    """Write the requested files."""
    if options.tum is not None:
        save_tum(options.tum / 'estimate.tum', errors.estimate)
        save_tum(options.tum / 'reference.tum', errors.reference)
    if options.csv is not None:
        save_error_table(options.csv, errors)
    if options.json is not None:
        write_text(options.json, json.dumps(report_to_dict(report), indent=2) + '\n')


def get_limits(options: argparse.Namespace) -> dict[str, float]:
    """Return the given limits by metric."""
    return {
        name.removeprefix('limit_'): value
        for name, value in vars(options).items()
        if name.startswith('limit_') and value is not None
    }


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(
        prog='check',
        description='Compare poses with ground truth, without alignment: both are in the same map frame. '
        'The reference is interpolated at the stamps of the estimate. Exit code 1 if a limit is exceeded.',
    )
    add = parser.add_argument
    add('estimate', type=Path, help='bag or TUM file with the estimated poses')
    add('--topic', help='topic of the poses, if the bag has several with poses')
    add('--reference', type=Path, help='bag or TUM file with the ground truth (default: ESTIMATE)')
    add('--reference-topic', help='topic of the ground truth, if the bag has several with poses')
    add('--images', metavar='TOPIC', help='topic in the reference bag; each of its messages should have a '
        'pose (default: each pose of the reference should have one)')  # fmt: skip
    add('--exclude', type=Path, metavar='CSV', help='intervals "start,end" [s] in which no poses are expected')
    add('--longest-gap', type=number_from_zero, default=0.5, metavar='SECONDS',
        help='the reference is not interpolated over longer gaps (default: %(default)s)')  # fmt: skip
    add('--tum', type=Path, metavar='FOLDER', help='write estimate.tum and reference.tum to it, at the same '
        'stamps, for "evo_ape tum reference.tum estimate.tum"')  # fmt: skip
    add('--csv', type=Path, help='write the errors of each pose to this file')
    add('--json', type=Path, help='write the report to this file')
    limits = parser.add_argument_group('limits, [m] and [rad]')
    for quantity in ('position', 'heading'):
        for statistic in STATISTICS:
            limits.add_argument(
                f'--max-{quantity}-{statistic}', type=number_from_zero, metavar='LIMIT',
                dest=f'limit_{quantity}_{statistic}',
            )  # fmt: skip
    limits.add_argument('--min-coverage', type=number_from_zero, metavar='FRACTION', dest=f'limit_{COVERAGE}',
                        help='fraction of the expected poses, 0 to 1')  # fmt: skip
    return parser


COLUMNS = (
    'stamp', 'position_error', 'heading_error',
    'x', 'y', 'yaw', 'reference_x', 'reference_y', 'reference_yaw',
)  # fmt: skip


def save_error_table(path: Path | str, errors: TrajectoryErrors) -> None:
    """Write one line per compared pose, in seconds, metres and radians."""
    numbers = np.column_stack(
        [errors.position, errors.heading, planar_poses(errors.estimate), planar_poses(errors.reference)]
    )
    poses = zip(errors.estimate.stamps_ns, numbers, strict=True)
    rows = ([text_from_stamp(stamp_ns), *(f'{number:.9g}' for number in row)] for stamp_ns, row in poses)
    write_csv(path, COLUMNS, rows)


def load_intervals(path: Path | str) -> NDArray[np.int64]:
    """Load a CSV file with the columns ``start`` and ``end`` [s] as an array of int64, shape (n, 2) [ns]; n
    may be 0.

    Raises:
        TrajectoryError: the file is missing, has no such columns, or a line is malformed.
    """
    intervals = []
    try:
        with Path(path).open(encoding='utf-8', newline='') as file:
            rows = csv.DictReader(file)
            if not {'start', 'end'} <= set(rows.fieldnames or ()):
                raise TrajectoryError(f'{path}: has no columns start and end; write the header "start,end"')
            for row in rows:
                try:
                    start, end = stamp_from_text(row['start'] or ''), stamp_from_text(row['end'] or '')
                except ValueError as fault:
                    raise TrajectoryError(f'{path}, line {rows.line_num}: {fault}; write seconds') from fault
                if end < start:
                    raise TrajectoryError(f'{path}, line {rows.line_num}: ends before it starts; swap the two')
                intervals.append((start, end))
    except (OSError, UnicodeDecodeError) as fault:
        raise TrajectoryError(f'{path}: cannot be read ({fault}); give a CSV file "start,end"') from fault
    return np.array(intervals, dtype=np.int64).reshape(-1, 2)


if __name__ == '__main__':
    sys.exit(main())
