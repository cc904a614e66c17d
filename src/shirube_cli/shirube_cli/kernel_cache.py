"""Machine code of the compiled loops: made once after a build, and never older than its sources.

Numba keeps machine code beside the sources and renews it when the file of a function changes, but not when
a function that was compiled into it changes in another file. So each state of the sources gets its own cache.
"""

import shutil
import subprocess
import sys
from pathlib import Path

from tqdm import tqdm

from shirube_cli.error import CommandError


def compile_loops(environment: dict[str, str]) -> None:
    """Let floor_localizer compile its loops, so that whatever uses them starts in seconds from then on.

    Args:
        environment: the one that they will be used in.

    Raises:
        CommandError: the loops cannot be compiled; the messages stand above.
    """
    command = [sys.executable, '-m', 'floor_localizer.core.warm_up']
    interval = 0.5 if sys.stderr.isatty() else 10.0
    with (
        subprocess.Popen(command, env=environment) as compiler,
        tqdm(desc='Compiling the search (once)', bar_format='{desc}: {elapsed}', mininterval=interval) as bar,
    ):
        while compiler.poll() is None:
            bar.update()
            try:
                compiler.wait(0.5)
            except subprocess.TimeoutExpired:
                continue
    if compiler.returncode:
        raise CommandError('the loops of floor_localizer could not be compiled; the messages stand above')


def fresh_cache(folder: Path, digest: str) -> Path:
    """Return the cache of one state of the sources in a folder, and remove those of other states."""
    cache = folder / digest[:16]
    for other in folder.glob('*'):
        if other != cache:
            shutil.rmtree(other, ignore_errors=True)
    return cache
