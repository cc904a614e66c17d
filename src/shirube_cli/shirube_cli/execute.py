"""Starts an executable of the installed product: ``python -m shirube_cli.execute <package> <executable> ...``."""

import sys
from importlib.metadata import entry_points

from shirube_cli.workspace import EXECUTABLES


def main() -> int:
    """Run the executable that the first two arguments name with the others."""
    package, executable, *rest = sys.argv[1:]
    (point,) = entry_points(group=EXECUTABLES, name=f'{package}.{executable}')
    sys.argv = [executable, *rest]
    return int(point.load()() or 0)


if __name__ == '__main__':
    sys.exit(main())
