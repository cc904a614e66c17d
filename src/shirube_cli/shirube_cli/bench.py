"""``shirube bench``: one of the benchmarks."""

import subprocess
import sys
from collections.abc import Sequence

from shirube_cli.error import CommandError
from shirube_cli.project import find_root, safe_environment


def bench(arguments: Sequence[str]) -> int:
    """Run ``benchmarks/<name>.py`` at the root with the remaining arguments and return its exit code.

    Raises:
        CommandError: no such benchmark; the message lists those that are there.
    """
    root = find_root()
    names = sorted(p.stem for p in (root / 'benchmarks').glob('*.py') if not p.stem.startswith('_'))
    if not arguments or arguments[0] not in names:
        raise CommandError(
            f'usage: shirube bench <name> [arguments …]; names: {", ".join(names) or "none yet"}'
        )
    command = [sys.executable, str(root / 'benchmarks' / f'{arguments[0]}.py'), *arguments[1:]]
    return subprocess.run(command, cwd=root, env=safe_environment(), check=False).returncode
