"""``shirube bench``: one of the benchmarks."""

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from shirube_cli.development_packages import install_development_packages
from shirube_cli.error import CommandError
from shirube_cli.kernel_cache import kernel_folder
from shirube_cli.project import find_root, safe_environment


def bench(arguments: Sequence[str]) -> int:
    """Run ``benchmarks/<name>.py`` or ``benchmarks/<name>/run.py`` with the remaining arguments.

    Returns:
        its exit code.

    Raises:
        CommandError: no such benchmark; the message lists those that are there.
    """
    root = find_root()
    programs = find_benchmarks(root)
    names = list(programs)
    if not arguments or arguments[0] not in programs:
        raise CommandError(
            f'usage: shirube bench <name> [arguments ...]; names: {", ".join(names) or "none yet"}'
        )
    install_development_packages()
    command = [sys.executable, str(programs[arguments[0]]), *arguments[1:]]
    # The machine code of the tests, as far as it is there, so that nothing is compiled while something is measured.
    environment = {'NUMBA_CACHE_DIR': str(kernel_folder(root)), **safe_environment()}
    return subprocess.run(command, cwd=root, env=environment, check=False).returncode


def find_benchmarks(root: Path) -> dict[str, Path]:
    """Return the benchmarks' programs by name."""
    return {
        program.stem if program.stem != 'run' else program.parent.name: program
        for program in sorted((root / 'benchmarks').glob('**/*.py'))
        if program.stem == 'run' or (program.parent.name == 'benchmarks' and program.stem[0] != '_')
    }
