"""``shirube run`` starts an executable of a package, as ``ros2 run`` does; ``shirube list`` names them."""

import os
import sys
from collections.abc import Sequence
from contextlib import chdir
from pathlib import Path
from runpy import run_path
from typing import Any, NoReturn
from unittest.mock import patch

from shirube_cli.bench import find_benchmarks
from shirube_cli.kernel_registry import sets_of_package
from shirube_cli.project import CommandError, find_root
from shirube_cli.workspace import build_workspace, find_executable, find_packages, overlay_environment

USAGE = 'usage: shirube run <package> <executable> [arguments ... --ros-args ...]'


def run(arguments: Sequence[str]) -> NoReturn:
    """Replace this process by the executable that ``ros2 run`` would start; raise a CommandError if there is
    none.
    """
    if len(arguments) < 2:
        raise CommandError(USAGE)
    package, executable, *rest = arguments
    root = find_root()
    build_workspace(root, sets_of_package(root, package))
    path = find_executable(root, package, executable)
    # Through the interpreter, because a first line `#!` cannot name one whose path has spaces.
    os.execve(sys.executable, [sys.executable, str(path), *rest], overlay_environment(root))


def view(arguments: Sequence[str]) -> NoReturn:
    """Replace this process by the live view."""
    run(['shirube_view', 'view', *arguments])


def list_programs(arguments: Sequence[str]) -> int:
    """Print what ``run`` and ``bench`` can start; return 0."""
    if arguments:
        raise CommandError('usage: shirube list')
    root = find_root()
    executables = {name: find_scripts(root / 'src' / name) for name in find_packages(root)}
    print('shirube run <package> <executable> [arguments ...]')
    for package, names in executables.items():
        if names:
            print(f'  {package:<20} {", ".join(names)}')
    print('shirube bench <name> [arguments ...]')
    for name in find_benchmarks(root):
        print(f'  {name}')
    return 0


def find_scripts(folder: Path) -> list[str]:
    """Return the names of the executables of a package's folder."""
    settings: dict[str, Any] = {}
    with chdir(folder), patch('setuptools.setup', lambda **given: settings.update(given)):
        run_path('setup.py')
    lines = settings.get('entry_points', {}).get('console_scripts', [])
    return sorted(line.partition('=')[0].strip() for line in lines)
