"""``shirube run``: starts an executable of a package, as ``ros2 run`` does."""

import os
import sys
from collections.abc import Sequence
from typing import NoReturn

from shirube_cli.error import CommandError
from shirube_cli.kernel_registry import sets_of_package
from shirube_cli.project import find_root
from shirube_cli.workspace import build_workspace, find_executable, overlay_environment

USAGE = 'usage: shirube run <package> <executable> [arguments ... --ros-args ...]'


def run(arguments: Sequence[str]) -> NoReturn:
    """Replace this process by the executable that ``ros2 run`` would start.

    Raises:
        CommandError: no such package or executable, or the workspace cannot be built.
    """
    if len(arguments) < 2:
        raise CommandError(USAGE)
    package, executable, *rest = arguments
    root = find_root()
    build_workspace(root, sets_of_package(root, package))
    path = find_executable(root, package, executable)
    # Through the interpreter, because a first line `#!` cannot name one whose path has spaces.
    os.execve(sys.executable, [sys.executable, str(path), *rest], overlay_environment(root))
