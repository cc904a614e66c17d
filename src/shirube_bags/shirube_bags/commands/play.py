"""``play``: replay a bag to live nodes, lossless, with ``/clock``."""

import argparse
import os
import select
import sys
import termios
import tty
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib.resources import as_file, files
from pathlib import Path
from threading import Event

from rclpy.utilities import remove_ros_args
from tqdm import tqdm

from shirube_bags.bag_reader import BagReader
from shirube_bags.errors import ReplayError, ShirubeBagsError
from shirube_bags.lockstep import Lockstep
from shirube_bags.replay import replay, wait_for_any, wait_for_counts
from shirube_bags.ros_session import BagPlayer, load_message_class, ros_session, stop_on_signals
from shirube_bags.stamps import NANOSECONDS, number_from_zero

PAUSE_KEY = b' '


@contextmanager
def pause_key(on_change: Callable[[bool], None]) -> Iterator[Callable[[], bool]]:
    """Provide a function that reads the keys and returns whether the replay is paused.

    It always returns False where no terminal is in the foreground. The terminal's mode is restored at the end.

    Args:
        on_change: called with the new state after each key.
    """
    terminal = sys.stdin.fileno() if is_in_foreground() else None
    paused = False

    def is_paused() -> bool:
        nonlocal paused
        while terminal is not None and select.select([terminal], [], [], 0.0)[0]:
            keys = os.read(terminal, 1024)
            if not keys:  # the terminal is gone
                break
            if keys.count(PAUSE_KEY) % 2:
                paused = not paused
                on_change(paused)
        return paused

    if terminal is None:
        yield is_paused
        return
    former = termios.tcgetattr(terminal)
    try:
        tty.setcbreak(terminal)
        yield is_paused
    finally:
        termios.tcsetattr(terminal, termios.TCSADRAIN, former)


def is_in_foreground() -> bool:
    """Return whether stdin is a terminal of which this process may read; a job in the background would be stopped."""
    try:
        return os.tcgetpgrp(sys.stdin.fileno()) == os.getpgrp()
    except (AttributeError, OSError, ValueError):  # no stdin, closed, or no terminal
        return False


# Timeout for delivery of the last messages before the program ends [s].
DELIVERY_TIMEOUT = 5.0
PROGRESS_BAR = '{l_bar}{bar}| {n:.1f}/{total:.1f} s [{elapsed}<{remaining}]'


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0 at the end of the bag or after Ctrl-C, 1 after an error."""
    command_line = list(sys.argv if arguments is None else ['play', *arguments])
    options = make_parser().parse_args(remove_ros_args(command_line)[1:])
    try:
        with as_file(files('shirube_bags') / 'fastdds_replay.xml') as profile, stop_on_signals() as stop:
            os.environ.setdefault('FASTRTPS_DEFAULT_PROFILES_FILE', str(profile))
            play(options, command_line, stop)
    except ShirubeBagsError as fault:
        print(f'play: {fault}', file=sys.stderr)
        return 1
    return 0


def play(options: argparse.Namespace, command_line: Sequence[str], stop: Event) -> None:
    """Replay the bag until its end or until ``stop`` is set."""
    with BagReader(options.bag) as bag, ros_session('bag_player', command_line) as session:
        if options.start_offset >= (duration := (bag.end_ns - bag.start_ns) / NANOSECONDS) > 0.0:
            raise ReplayError(
                f'--start-offset {options.start_offset:g}: the bag ends after {duration:.1f} s; give less'
            )
        topics = playable_topics(bag, options.topics)
        player = BagPlayer(session.node, [bag.topics[topic] for topic in topics])
        lockstep = Lockstep(player, session.node, session.executor, should_stop=stop.is_set)
        wait_for_subscribers(options, player, stop)
        # The first responses show that the nodes have discovered this player, too.
        lockstep.wait(topics)
        if lockstep.nodes_without_services:
            log(f'{", ".join(lockstep.nodes_without_services)} has no parameter service and may lose messages')
        step = lockstep if options.lockstep or options.rate == 0.0 else None
        with pause_key(lambda paused: log('paused; space continues' if paused else 'continued')) as is_paused:
            for _ in range(options.loop):
                if stop.is_set():
                    break
                play_once(bag, player, options, step, stop, is_paused)
        player.wait_until_received(topics, DELIVERY_TIMEOUT)
        lockstep.wait(topics)


def play_once(
    bag: BagReader,
    player: BagPlayer,
    options: argparse.Namespace,
    lockstep: Lockstep | None,
    stop: Event,
    is_paused: Callable[[], bool],
) -> None:
    """Replay the bag once with a progress bar, and report the speed."""
    player.rewind()
    duration = (bag.end_ns - bag.start_ns) / NANOSECONDS - options.start_offset
    with tqdm(total=duration, delay=1.0, mininterval=0.5, bar_format=PROGRESS_BAR) as bar:
        result = replay(
            *(bag, player, options.rate, lockstep),
            stop=stop,
            on_progress=lambda played: bar.update(played - bar.n),
            start_offset=options.start_offset,
            is_paused=is_paused,
        )
    speed = result.bag_duration / max(result.elapsed, 1e-9)
    log(
        f'{result.messages} messages, {result.bag_duration:.1f} s of the bag '
        f'in {result.elapsed:.1f} s ({speed:.2f} x real time)'
    )


def wait_for_subscribers(options: argparse.Namespace, player: BagPlayer, stop: Event) -> None:
    """Wait for the subscribers of ``--wait-for``, or else for any; report topics without one, raise for
    missing ones.
    """
    wanted = dict(options.wait_for)
    for topic in wanted:
        if topic not in player.topics:
            raise ReplayError(f'--wait-for {topic}: is not replayed; replayed topics:  {", ".join(player.topics)}')
    if wanted:
        wait_for_counts(player.subscriber_count, wanted, options.timeout, stop.is_set)
    unsubscribed = wait_for_any(player.subscriber_count, player.topics, options.timeout, stop.is_set)
    if stop.is_set():
        return
    if len(unsubscribed) == len(player.topics):
        log(f'no subscriber within {options.timeout:g} s; playing anyway')
    elif unsubscribed:
        log(f'no subscriber for {", ".join(unsubscribed)}')


def playable_topics(bag: BagReader, wanted: Sequence[str]) -> list[str]:
    """Return the topics to play; types that are not installed are skipped, or a ReplayError if they are wanted."""
    topics = []
    for topic in bag.select_topics(wanted):
        try:
            load_message_class(bag.topics[topic].msgtype)
        except ReplayError as fault:
            if wanted:
                raise ReplayError(f'{bag.path}, topic {topic}: {fault}') from fault
            log(f'topic {topic} is skipped: {fault}')
        else:
            topics.append(topic)
    if not topics:
        raise ReplayError(f'{bag.path}: no topic can be played; install the packages of its message types')
    return topics


def log(line: str) -> None:
    """Print a line without breaking the progress bar."""
    tqdm.write(f'play: {line}', file=sys.stderr)


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(
        prog='play',
        description='Replay a bag to live nodes, with /clock. Topics are published reliably, so no message '
        'is lost on the network; nodes slower than the replay need --lockstep (or --rate 0) to lose '
        'none in their queues. The space bar pauses and continues. Give remappings after --ros-args.',
    )
    add = parser.add_argument
    add('bag', type=Path, help='folder of a rosbag2, or its .mcap or .db3 file')
    add('--rate', type=number_from_zero, default=1.0, metavar='R',
        help='playback rate (default: 1); 0: as fast as the nodes keep up, in lock step')  # fmt: skip
    add('--lockstep', action='store_true',
        help='publish a message only after the nodes have processed the last one')  # fmt: skip
    add('--start-offset', type=number_from_zero, default=0.0, metavar='SECONDS',
        help='leave out the beginning of the bag')  # fmt: skip
    add('--loop', type=loop_count, default=1, nargs='?', const=sys.maxsize, metavar='N',
        help='number of repetitions, without N until Ctrl-C; /clock jumps back each time')  # fmt: skip
    add('--topics', nargs='+', default=(), metavar='TOPIC', help='play only these topics')
    add('--wait-for', nargs='+', default=(), type=wanted_subscribers, metavar='TOPIC[/COUNT]',
        help='start when these topics have COUNT subscribers (default 1); without this option, any subscriber '
        'is waited for')  # fmt: skip
    add('--timeout', type=number_from_zero, default=10.0, metavar='SECONDS',
        help='how long to wait for subscribers (default: %(default)g)')  # fmt: skip
    return parser


def loop_count(text: str) -> int:
    """Return a number of repetitions, 1 or more; raise a ValueError if it is none."""
    number = int(text)
    if number < 1:
        raise ValueError(text)
    return number


def wanted_subscribers(text: str) -> tuple[str, int]:
    """Return the topic and the number in ``TOPIC/COUNT``; ``TOPIC`` alone means one subscriber."""
    topic, _, count = text.rpartition('/')
    return (topic, int(count)) if topic and count.isdigit() else (text, 1)


if __name__ == '__main__':
    sys.exit(main())
