"""``shirube demo``: the main job, with a report."""

import argparse
import shutil
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path

from shirube_cli.error import CommandError
from shirube_cli.kernel_registry import DEMO_SETS, sets_of_packages
from shirube_cli.project import find_root
from shirube_cli.workspace import build_workspace

# Loaded when asked for: the other commands start without matplotlib and ROS.
DEMOS = {
    'mission': ('shirube_cli.mission_demo', 'demo_mission', DEMO_SETS),
    'floor': ('shirube_cli.floor_demo', 'demo_floor', sets_of_packages(['floor_localizer'])),
}
"""Module, function, and the kernels that it needs."""


def demo(arguments: Sequence[str]) -> int:
    """Run the demo that is asked for; return 0 when the result is within the limits, 1 otherwise.

    Raises:
        CommandError: there is no such demo, or it could not run.
    """
    parser = argparse.ArgumentParser(prog='shirube demo', description=__doc__)
    parser.add_argument('name', nargs='?', default='mission', help='which one (default: %(default)s)')
    name = parser.parse_args(arguments).name
    if name not in DEMOS:
        raise CommandError(f'there is no demo {name!r}; choose one of: {", ".join(DEMOS)}')
    root = find_root()
    module, function, sets = DEMOS[name]
    build_workspace(root, sets)
    folder = root / 'out' / 'demo'
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    run_demo: Callable[[Path, Path], int] = getattr(import_module(module), function)
    return run_demo(root, folder)
