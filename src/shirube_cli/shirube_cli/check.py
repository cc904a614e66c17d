"""``shirube check``: format, lint and types of the whole repository."""

import argparse
from collections.abc import Sequence

from shirube_cli.development_packages import install_development_packages
from shirube_cli.project import find_root, run_tool


def check(arguments: Sequence[str]) -> int:
    """Run the formatter, the linter and the type checker; return 0 when none of them finds an error."""
    parser = argparse.ArgumentParser(
        prog='shirube check', description='Format, lint and types of everything.'
    )
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
