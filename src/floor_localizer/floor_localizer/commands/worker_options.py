"""The options of a command whose tasks can run in several processes or on a cluster."""

from __future__ import annotations

import argparse
import os


def add_worker_options(parser: argparse.ArgumentParser) -> None:
    """Add ``--workers`` and ``--scheduler``, as `task_runner` takes them."""
    parser.add_argument(
        '--workers',
        type=_positive,
        default=os.cpu_count() or 1,
        help='processes on this computer (default: all cores)',
    )
    parser.add_argument(
        '--scheduler',
        metavar='ADDRESS',
        help='of a dask scheduler, as tcp://10.0.0.1:8786, whose workers see the same files: they do the work',
    )


def _positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError('must be at least 1')
    return number
