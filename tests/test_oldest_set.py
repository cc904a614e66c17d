"""What the code uses of numpy, scipy and OpenCV is there in the installed versions, the oldest ones above all.

Kernels need this most: machine code that the newest set made runs on the oldest one, too, where compiling it
would have failed.
"""

import ast
import importlib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
LIBRARIES = ('numpy', 'scipy', 'cv2')
PACKAGES = sorted(path.parent for path in ROOT.glob('src/*/*/py.typed'))


def taken_names(tree: ast.Module) -> Iterator[str]:
    """Yield the full name of whatever a file takes from the libraries."""
    modules: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                modules[alias.asname or alias.name.partition('.')[0]] = (
                    alias.name if alias.asname else alias.name.partition('.')[0]
                )
                yield alias.name
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            for alias in node.names:
                modules[alias.asname or alias.name] = f'{node.module}.{alias.name}'
                yield f'{node.module}.{alias.name}'
    for node in ast.walk(tree):
        name = full_name(node, modules)
        if name is not None:
            yield name


def full_name(node: ast.AST, modules: dict[str, str]) -> str | None:
    """Return what a chain of attributes such as ``np.linalg.norm`` stands for, None for other expressions."""
    if isinstance(node, ast.Name):
        return modules.get(node.id)
    if isinstance(node, ast.Attribute):
        owner = full_name(node.value, modules)
        return None if owner is None else f'{owner}.{node.attr}'
    return None


def is_there(name: str) -> bool:
    """Tell whether a full name can be imported or is an attribute of what can."""
    parts = name.split('.')
    found = None
    for count, part in enumerate(parts, start=1):
        if found is not None and hasattr(found, part):
            found = getattr(found, part)
            continue
        try:
            found = importlib.import_module('.'.join(parts[:count]))
        except ImportError:
            return False
    return True


@pytest.mark.parametrize('package', PACKAGES, ids=lambda path: path.name)
def test_all_names_taken_from_the_libraries_are_there(package: Path) -> None:
    missing = {
        f'{path.relative_to(ROOT)}: {name}'
        for path in package.rglob('*.py')
        for name in taken_names(ast.parse(path.read_bytes()))
        if name.partition('.')[0] in LIBRARIES and not is_there(name)
        # Asked for by its name, it is known to be missing from one of the sets.
        if f"hasattr({name.rpartition('.')[0]}, '{name.rpartition('.')[2]}')" not in path.read_text()
    }
    assert not missing


def test_a_name_that_is_not_there_is_found() -> None:
    names = set(taken_names(ast.parse('import numpy as np\ndef f(x):\n    return np.linalg.nothing(np.abs(x))')))
    assert {name for name in names if not is_there(name)} == {'numpy.linalg.nothing'}
