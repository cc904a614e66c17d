"""``shirube test``, ``shirube check`` and ``shirube bench``, and the packages that they need."""

import argparse
import ast
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from shirube_cli.kernel_cache import compiled_kernels, kernel_folder
from shirube_cli.project import CommandError, find_root, run_tool, safe_environment
from shirube_cli.workspace import build_workspace

_SCRIPT = 'source "$0/environment/ensure.bash"; forget_other_environments; ensure_development "$0"'


def install_development_packages() -> None:
    """Complete the environment that ``./shirube`` made, or raise a CommandError; leave every other one as it is."""
    root = find_root()
    if Path(sys.prefix) != root / '.venv':
        return
    if subprocess.run(['bash', '-c', _SCRIPT, str(root)], check=False).returncode:
        raise CommandError('the packages for tests, checks and benchmarks are not installed; see above')


QUICK = '--quick'
# These want pytest's own process, or choose the number of processes themselves.
ONE_PROCESS = (*('-n', '--numprocesses', '--dist', '--pdb', '--trace', '-s', '--capture=no', '--collect-only', '--co'),)


def run_tests(arguments: Sequence[str]) -> int:
    """Run pytest at the root of the repository with its arguments and ``--quick``; return its exit code."""
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
        chosen = [*parallel_options(), *chosen]
    return run_tool('pytest', chosen)


def parallel_options() -> list[str]:
    """Return the options that let pytest use all cores: many tests wait, so one process more than there are cores."""
    return [f'-n{len(os.sched_getaffinity(0)) + 1}', '--dist=worksteal']


def check(arguments: Sequence[str]) -> int:
    """Run the formatter, the linter and the type checker; return 0 when none of them finds an error."""
    parser = argparse.ArgumentParser(prog='shirube check', description='Format, lint and types of everything.')
    parser.add_argument('--fix', action='store_true', help='fix what can be fixed automatically')
    fix = parser.parse_args(arguments).fix
    install_development_packages()
    failed = [
        run_tool('ruff', ['format', '.'] if fix else ['format', '--check', '.']),
        run_tool('ruff', ['check', '--fix', '.'] if fix else ['check', '.']),
        run_tool('mypy', _typed_folders()),
    ]
    return int(any(failed))


def _typed_folders() -> list[str]:
    root = find_root()
    packages = sorted(marker.parent for marker in root.glob('src/*/*/py.typed'))
    others = [folder for folder in (root / 'environment', root / 'benchmarks') if any(folder.glob('*.py'))]
    return [str(path.relative_to(root)) for path in (*packages, *others)]


USAGE = 'usage: shirube bench <name> [--quick] [--save] [--compare] [arguments ...], or --all, or --tables'


def bench(arguments: Sequence[str]) -> int:
    """Run ``benchmarks/<name>.py`` with the remaining arguments, or list all without a name.

    ``--all`` runs every benchmark, ``--tables`` makes the tables of the pages from the kept results.

    Returns:
        its exit code.

    Raises:
        CommandError: no such benchmark.
    """
    root = find_root()
    programs = find_benchmarks(root)
    if not arguments:
        for name, program in programs.items():
            print(f'  {name:<20} {(ast.get_docstring(ast.parse(program.read_text())) or "").splitlines()[0]}')
        return 0
    if arguments[0] in {'-h', '--help'}:
        print(f'{USAGE}; names: {", ".join(programs)}')
        return 0
    if arguments[0] in programs:  # first: a benchmark may have a --tables of its own
        command = [sys.executable, str(programs[arguments[0]]), *arguments[1:]]
    elif {'--all', '--tables'} & set(arguments):
        command = [sys.executable, str(root / 'benchmarks' / '_run_all.py'), *arguments]
    else:
        raise CommandError(f'{USAGE}; names: {", ".join(programs)}')
    install_development_packages()
    # The machine code of the tests, as far as it is there, so that nothing is compiled while something is measured;
    # one thread of OpenBLAS, since all times are those of one core.
    environment = {
        'NUMBA_CACHE_DIR': str(kernel_folder(root)),
        'OPENBLAS_NUM_THREADS': '1',
        **safe_environment(),
        'PYTHONPATH': str(root / 'tests'),  # for node_testing
    }
    return subprocess.run(command, cwd=root, env=environment, check=False).returncode


def find_benchmarks(root: Path) -> dict[str, Path]:
    """Return the benchmarks' programs by name."""
    return {program.stem: program for program in sorted((root / 'benchmarks').glob('[!_]*.py'))}
