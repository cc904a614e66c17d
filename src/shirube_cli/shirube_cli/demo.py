"""``shirube demo``: the main job, with a report."""

import argparse
import os
import shutil
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path

from shirube_bringup.free_domain import free_domain
from shirube_cli.kernel_cache import PROGRESS_FILE
from shirube_cli.kernel_registry import DEMO_SETS, sets_of_packages
from shirube_cli.project import CommandError, child_process, find_home, is_clone, safe_environment
from shirube_cli.workspace import build_workspace, find_executable, overlay_environment

# Loaded when asked for: the other commands start without matplotlib and ROS.
DEMOS = {
    'mission': ('shirube_cli.demo', 'demo_mission', DEMO_SETS),
    'floor': ('shirube_cli.floor_demo', 'demo_floor', sets_of_packages(['floor_localizer'])),
}
"""Module, function, and the kernels that it needs."""


def demo(arguments: Sequence[str]) -> int:
    """Run the demo that is asked for; return 0 when the result is within the limits, 1 otherwise."""
    parser = argparse.ArgumentParser(prog='shirube demo', description=__doc__)
    parser.add_argument('name', nargs='?', default='mission', help='which one (default: %(default)s)')
    parser.add_argument('--planner', help='of the mission: default, or paper for its map and reward rule')
    options = parser.parse_args(arguments)
    name = options.name
    if name not in DEMOS:
        raise CommandError(f'there is no demo {name!r}; choose one of: {", ".join(DEMOS)}')
    if options.planner and name != 'mission':
        raise CommandError(f'--planner is an option of the mission; the demo {name!r} has no planner')
    root = find_home()
    module, function, sets = DEMOS[name]
    folder = (root if is_clone(root) else Path.cwd()) / 'out' / 'demo'
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    run_demo: Callable[..., int] = getattr(import_module(module), function)
    if name != 'mission':  # which builds while its live view is open
        build_workspace(root, sets)
    return run_demo(root, folder, *([options.planner] if options.planner else []))


def demo_mission(root: Path, folder: Path, planner: str = 'default') -> int:
    """Run the mission and leave its report, its numbers and the nodes' logs in the folder.

    The live view opens at once and plays a recorded mission until this one begins.

    Returns 0 when every goal was reached well and nothing was touched, else 1.
    """
    progress = folder / 'progress.txt'
    os.environ[PROGRESS_FILE] = str(progress)
    view = [sys.executable, '-m', 'shirube_view.commands.view', str(root / 'bags' / 'mission'), '--port', '0']
    view += ['--progress', str(progress), '--ros-args', '-p', 'use_sim_time:=true']
    with free_domain() as domain:
        environment = {**safe_environment(), 'ROS_DOMAIN_ID': str(domain)}
        with child_process(view, environment, log=None):
            build_workspace(root, DEMO_SETS)
            return _run_mission(root, folder, planner, domain)


def _run_mission(root: Path, folder: Path, planner: str, domain: int) -> int:
    bag = folder / 'bag'
    command = [*find_executable(root, 'shirube_bringup', 'room'), str(folder)]
    command += ['--planner', planner, '--domain', str(domain), '--record', str(bag)]
    with child_process(command, overlay_environment(root), log=None) as process:
        code = process.wait()
    if bag.exists():
        print(f'See it again: ./shirube view {bag}')
    return 1 if code else 0
