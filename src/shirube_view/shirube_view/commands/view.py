"""``view``: the live page in the browser; watch, set goals, drive by hand, stop, replay a bag."""

import argparse
import logging
import sys
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from threading import Thread

import rclpy
from rclpy._rclpy_pybind11 import RCLError
from rclpy.executors import ExternalShutdownException
from rclpy.signals import SignalHandlerOptions

from shirube_bags.bag_reader import check_is_bag
from shirube_bags.errors import BagError
from shirube_core.read_only import ensure_log_folder
from shirube_core.settings import SettingsError
from shirube_ros.node import node_executor
from shirube_ros.web.access import is_loopback, new_token, reachable_host
from shirube_ros.web.serving import serve
from shirube_view.bag_process import BagProcess
from shirube_view.view_node import ViewNode
from shirube_view.view_server import ViewServer

_PORT, _WAIT_MAX = 8770, 0.2


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command until Ctrl-C; return 0, or 1 after an error."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    own = given[: given.index('--ros-args')] if '--ros-args' in given else given
    options = make_parser().parse_args(own)
    logging.basicConfig(format='view: %(message)s', level=logging.WARNING)
    ensure_log_folder()
    try:
        for bag in options.bags:
            check_is_bag(bag)
        rclpy.init(args=['view', *given[len(own) :]], signal_handler_options=SignalHandlerOptions.NO)
        run(options)
    except (BagError, SettingsError) as fault:
        print(f'view: {fault}', file=sys.stderr)
        return 1
    except OSError as fault:
        print(f'view: {fault.strerror}; choose another --host or --port', file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 0
    finally:
        rclpy.try_shutdown()
    return 0


def run(options: argparse.Namespace) -> None:
    """Serve the page; the node spins in a thread of its own."""
    node = ViewNode()
    spinning = start_spinning(node)
    tokens = () if is_loopback(options.host) else (new_token(), new_token())
    server = ViewServer(
        *(node, options.bags, BagProcess(Path.cwd()), tokens),
        can_command=not options.watch_only,
        progress=partial(last_line, options.progress),
    )
    try:
        serve(server, options.host, options.port, partial(print_addresses, options.host, tokens))
    finally:
        node.stop()
        rclpy.try_shutdown()
        spinning.join(2.0)


def start_spinning(node: ViewNode) -> Thread:
    """Call the node's callbacks in a thread until its context is shut down."""

    def spin() -> None:
        # Made here: timers of an EventsExecutor fire only in the thread that made it.
        executor = node_executor(node.context)
        executor.add_node(node)
        with suppress(ExternalShutdownException, RCLError):
            while node.context.ok():
                executor.spin_once(timeout_sec=_WAIT_MAX)

    thread = Thread(target=spin, daemon=True)
    thread.start()
    return thread


def print_addresses(host: str, tokens: Sequence[str], port: int) -> None:
    """Print the address of the page, or those for commanding and for watching."""
    address = f'http://{reachable_host(host)}:{port}/'
    if not tokens:
        print(f'Live view: {address} (stop with Ctrl-C)', flush=True)
        return
    print(f'Live view: {address}?token={tokens[0]} (stop with Ctrl-C)', flush=True)
    print(f'To watch only: {address}?token={tokens[1]}', flush=True)


def last_line(path: Path | None) -> str:
    """Return the last line of a file about progress, empty if there is none."""
    try:
        lines = [] if path is None else path.read_text(errors='replace').split('\n')
    except OSError:
        return ''
    return next((line for line in reversed(lines) if line.strip()), '')


def make_parser() -> argparse.ArgumentParser:
    """Return the argument parser."""
    parser = argparse.ArgumentParser(
        prog='view',
        description='Open a page for the browser that shows the robot live: map, poses, plan, cameras; and '
        'commands it, or plays bags. Parameters and remapped topics follow after --ros-args.',
    )
    add = parser.add_argument
    add('bags', type=Path, nargs='*', metavar='BAG', help='bags to play; without one the page is live')
    add('--host', default='127.0.0.1', help='address to listen on; others than this machine need a token (default: '
        '%(default)s)')  # fmt: skip
    add('--port', type=int, default=_PORT, help='port, 0 for any free one (default: %(default)s)')
    add('--watch-only', action='store_true', help='no page commands the robot')
    add('--progress', type=Path, metavar='FILE', help='show the last line of a file while no robot is live')
    return parser


if __name__ == '__main__':
    sys.exit(main())
