"""``shirube test``: the whole test suite."""

import os
import sys
from collections.abc import Sequence
from pathlib import Path

from shirube_cli.kernel_cache import compile_loops, digest_loops, fresh_cache
from shirube_cli.project import find_root, run_tool, safe_environment
from shirube_cli.workspace import build_workspace


def run_tests(arguments: Sequence[str]) -> int:
    """Run pytest at the root of the repository with the given arguments and return its exit code."""
    root = find_root()
    # Of this environment, because numba does not tell machine code for another numpy apart.
    cache = fresh_cache(Path(sys.prefix) / 'numba', digest_loops(root / 'src'))
    os.environ.setdefault('NUMBA_CACHE_DIR', str(cache))
    if all(argument.startswith('-') for argument in arguments):
        # The whole suite will need these, and the time of a single test is limited.
        build_workspace(root)
        if not Path(os.environ['NUMBA_CACHE_DIR']).exists():
            compile_loops(safe_environment())
    return run_tool('pytest', arguments)
