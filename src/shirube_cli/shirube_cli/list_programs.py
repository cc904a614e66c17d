"""``shirube list``: the packages with their executables, and the benchmarks."""

import ast
from collections.abc import Sequence
from pathlib import Path

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
    executables = {name: find_scripts(root / 'src' / name / 'setup.py') for name in find_packages(root)}
    print('shirube run <package> <executable> [arguments ...]')
    for package, names in executables.items():
        if names:
            print(f'  {package:<20} {", ".join(names)}')
    print('shirube bench <name> [arguments ...]')
    for name in find_benchmarks(root):
        print(f'  {name}')
    return 0


def find_scripts(setup: Path) -> list[str]:
    """Return the names of a package's executables, without running its ``setup.py``.

    Args:
        setup: the file that names them as ``console_scripts``.
    """
    for node in ast.walk(ast.parse(setup.read_bytes())):
        if isinstance(node, ast.Dict):
            for key, value in zip(node.keys, node.values, strict=True):
                if isinstance(key, ast.Constant) and key.value == 'console_scripts':
                    assert isinstance(value, ast.List)
                    return sorted(_first_text(entry).partition('=')[0].strip() for entry in value.elts)
    return []


def _first_text(entry: ast.expr) -> str:
    """Return the text of a string or the first part of an f-string."""
    part = entry.values[0] if isinstance(entry, ast.JoinedStr) else entry
    return str(part.value) if isinstance(part, ast.Constant) else ''
