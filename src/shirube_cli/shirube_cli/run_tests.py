"""``shirube test``: the whole test suite on all cores, or with ``--quick`` the safety net alone."""

import os
from collections.abc import Sequence
from pathlib import Path

from shirube_cli.development_packages import install_development_packages
from shirube_cli.kernel_cache import compiled_kernels, kernel_folder
from shirube_cli.project import find_root, run_tool
from shirube_cli.workspace import build_workspace

QUICK = '--quick'
# These want pytest's own process, or choose the number of processes themselves.
ONE_PROCESS = (
    '-n',
    '--numprocesses',
    '--dist',
    '--pdb',
    '--trace',
    '-s',
    '--capture=no',
    '--collect-only',
    '--co',
)


def run_tests(arguments: Sequence[str]) -> int:
    """Run pytest at the root of the repository and return its exit code.

    Args:
        arguments: arguments of pytest; ``--quick`` runs only the tests that guard every commit.
    """
    install_development_packages()
    root = find_root()
    is_whole = not any(Path(argument.partition('::')[0]).exists() for argument in arguments)
    if is_whole and QUICK not in arguments:
        # The whole suite will need these, and the time of a single test is limited.
        build_workspace(root)
    if is_whole:
        os.environ.setdefault('NUMBA_CACHE_DIR', str(compiled_kernels(root)))
        # The processes keep the cores busy; threads for matrices of a few rows would only wait for each other.
        os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    else:
        os.environ.setdefault('NUMBA_CACHE_DIR', str(kernel_folder(root)))
    chosen = ['-m', 'quick', *(a for a in arguments if a != QUICK)] if QUICK in arguments else list(arguments)
    if is_whole and not any(argument.startswith(ONE_PROCESS) for argument in arguments):
        chosen = [*processes(), *chosen]
    return run_tool('pytest', chosen)


def processes() -> list[str]:
    """Return the options that let pytest use all cores: many tests wait, so one process more than there are cores."""
    return [f'-n{len(os.sched_getaffinity(0)) + 1}', '--dist=worksteal']
