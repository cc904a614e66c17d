"""``shirube test``: the whole test suite."""

import os
from collections.abc import Sequence
from pathlib import Path

from shirube_cli.kernel_cache import compiled_loops, loops_folder
from shirube_cli.project import find_root, run_tool
from shirube_cli.workspace import build_workspace


def run_tests(arguments: Sequence[str]) -> int:
    """Run pytest at the root of the repository with the given arguments and return its exit code."""
    root = find_root()
    if not any(Path(argument.partition('::')[0]).exists() for argument in arguments):
        # The whole suite will need these, and the time of a single test is limited.
        build_workspace(root)
        os.environ.setdefault('NUMBA_CACHE_DIR', str(compiled_loops(root)))
    else:
        os.environ.setdefault('NUMBA_CACHE_DIR', str(loops_folder(root)))
    return run_tool('pytest', arguments)
