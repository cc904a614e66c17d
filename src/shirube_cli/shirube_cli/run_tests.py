"""``shirube test``: the whole test suite."""

import os
from collections.abc import Sequence

from shirube_cli.kernel_cache import fresh_cache
from shirube_cli.project import find_root, run_tool
from shirube_cli.workspace import digest_package


def run_tests(arguments: Sequence[str]) -> int:
    """Run pytest at the root of the repository with the given arguments and return its exit code."""
    root = find_root()
    cache = fresh_cache(root / 'out' / 'numba', digest_package(root / 'src' / 'floor_localizer'))
    os.environ.setdefault('NUMBA_CACHE_DIR', str(cache))
    return run_tool('pytest', arguments)
