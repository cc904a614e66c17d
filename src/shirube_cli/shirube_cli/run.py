"""``shirube run`` starts an executable of a package, as ``ros2 run`` does; ``shirube list`` names them."""

import os
import sys
from collections.abc import Sequence
from configparser import ConfigParser
from importlib.metadata import version
from pathlib import Path
from typing import NoReturn

from shirube_cli.develop import find_benchmarks
from shirube_cli.kernel_registry import sets_of_package
from shirube_cli.project import CommandError, find_home, is_clone
from shirube_cli.workspace import (
    build_workspace,
    find_executable,
    find_packages,
    installed_executables,
    overlay_environment,
)

USAGE = 'usage: shirube run <package> <executable> [arguments ... --ros-args ...]'


def run(arguments: Sequence[str]) -> NoReturn:
    """Replace this process by the executable that ``ros2 run`` would start; raise a CommandError if there is none."""
    if len(arguments) < 2:
        raise CommandError(USAGE)
    package, executable, *rest = arguments
    root = find_home()
    build_workspace(root, sets_of_package(root, package))
    command = find_executable(root, package, executable)
    os.execve(sys.executable, [*command, *rest], overlay_environment(root))


def view(arguments: Sequence[str]) -> NoReturn:
    """Replace this process by the live view."""
    run(['shirube_view', 'view', *arguments])


def list_programs(arguments: Sequence[str]) -> int:
    """Print what ``run`` and ``bench`` can start; return 0."""
    if arguments:
        raise CommandError('usage: shirube list')
    root = find_home()
    executables = {name: find_scripts(root, name) for name in find_packages(root)}
    print('shirube run <package> <executable> [arguments ...]')
    for package, names in executables.items():
        if names:
            print(f'  {package:<20} {", ".join(names)}')
    if is_clone(root):
        print('shirube bench <name> [arguments ...]')
        for name in find_benchmarks(root):
            print(f'  {name}')
    return 0


def print_version(arguments: Sequence[str]) -> int:
    """Print version and place of this program; return 0."""
    if arguments:
        raise CommandError('usage: shirube --version')
    print(f'shirube {version("shirube")} in {find_home()}, Python {sys.version.split()[0]}')
    return 0


def find_scripts(root: Path, package: str) -> list[str]:
    """Return the names of the executables of a package."""
    if not is_clone(root):
        return sorted(installed_executables()[package])
    config = ConfigParser()
    config.read(root / 'src' / package / 'setup.cfg')
    lines = config.get('options.entry_points', 'console_scripts', fallback='').split('\n')
    return sorted(line.partition('=')[0].strip() for line in lines if line)
