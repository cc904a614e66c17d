"""Command line options for commands that run tasks in several processes or on a cluster."""

from __future__ import annotations

import argparse
import os


def add_worker_options(parser: argparse.ArgumentParser) -> None:
    """Add ``--workers`` and ``--scheduler``, the arguments of `task_runner`."""
    parser.add_argument(
        '--workers',
        type=_positive,
        default=os.cpu_count() or 1,
        help='number of local processes (default: all cores)',
    )
    parser.add_argument(
        '--scheduler',
        metavar='ADDRESS',
        help='address of a dask scheduler, such as tcp://10.0.0.1:8786, whose workers access the same files',
    )


def _positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError('must be at least 1')
    return number
