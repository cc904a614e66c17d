"""``shirube list``: the packages with their executables, and the benchmarks."""

from collections.abc import Sequence
from contextlib import chdir
from pathlib import Path
from runpy import run_path
from typing import Any
from unittest.mock import patch

from shirube_cli.bench import find_benchmarks
from shirube_cli.error import CommandError
from shirube_cli.project import find_root
from shirube_cli.workspace import find_packages


def list_programs(arguments: Sequence[str]) -> int:
    """Print what ``run`` and ``bench`` can start; return 0.

    Raises:
        CommandError: there are arguments.
    """
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
    """Return the names of a package's executables.

    Args:
        folder: the package, with its ``setup.py``.
    """
    settings: dict[str, Any] = {}
    with chdir(folder), patch('setuptools.setup', lambda **given: settings.update(given)):
        run_path('setup.py')
    lines = settings.get('entry_points', {}).get('console_scripts', [])
    return sorted(line.partition('=')[0].strip() for line in lines)
