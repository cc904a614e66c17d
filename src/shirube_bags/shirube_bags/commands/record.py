"""``record``: record live topics into a bag, which is created atomically."""

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from threading import Event

from rclpy.utilities import remove_ros_args

from shirube_bags.bag_writer import BagWriter
from shirube_bags.errors import ReplayError, ShirubeBagsError
from shirube_bags.ros_session import BagRecorder, RosSession, ros_session, stop_on_signals

SEARCH_INTERVAL = 0.1


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command until Ctrl-C; return 0, or 1 after an error or if nothing was recorded."""
    command_line = list(sys.argv if arguments is None else ['record', *arguments])
    options = make_parser().parse_args(remove_ros_args(command_line)[1:])
    try:
        with (
            stop_on_signals() as stop,
            ros_session('bag_recorder', command_line, options.use_sim_time) as session,
            BagWriter(options.output) as bag,
        ):
            recorder = BagRecorder(session.node, bag, options.topics, log)
            record(session, recorder, stop)
            check_recording(recorder, options.output)
    except ShirubeBagsError as fault:
        log(str(fault))
        return 1
    for topic, count in sorted(recorder.counts.items()):
        log(f'{count:>8} messages of {topic}')
    log(f'wrote {options.output}')
    return 0


def record(session: RosSession, recorder: BagRecorder, stop: Event) -> None:
    """Record until ``stop`` is set."""
    next_search = time.monotonic()
    while not stop.is_set():
        if time.monotonic() >= next_search:
            recorder.find_topics()
            next_search = time.monotonic() + SEARCH_INTERVAL
        session.executor.spin_once(timeout_sec=SEARCH_INTERVAL)


def check_recording(recorder: BagRecorder, output: Path) -> None:
    """Report the topics that are missing from the recording; raise a ReplayError if nothing was recorded."""
    if recorder.missing_topics:
        log(f'never published: {", ".join(recorder.missing_topics)}')
    if not any(recorder.counts.values()):
        raise ReplayError(f'{output}: no message received, nothing is written; check the topics and ROS_DOMAIN_ID')


def log(line: str) -> None:
    """Print a line."""
    print(f'record: {line}', file=sys.stderr, flush=True)


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(
        prog='record',
        description='Record topics into a bag (mcap, compressed) until Ctrl-C. The bag is written under a '
        'temporary name and renamed at the end. Give remappings after --ros-args.',
    )
    parser.add_argument('topics', nargs='*', metavar='TOPIC', help='topics to record (default: all)')
    parser.add_argument('-o', '--output', type=Path, required=True, metavar='BAG', help='folder to create')
    parser.add_argument('--use-sim-time', action='store_true', help='stamp with /clock, for example of a replay')
    return parser


if __name__ == '__main__':
    sys.exit(main())
