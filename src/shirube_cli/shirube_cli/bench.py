"""``shirube bench``: one of the benchmarks, all of them, or the tables of their results."""

import ast
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from shirube_cli.develop import install_development_packages
from shirube_cli.kernel_cache import kernel_folder
from shirube_cli.project import CommandError, find_root, safe_environment

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
