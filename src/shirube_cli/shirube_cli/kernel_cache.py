"""Machine code of the compiled loops: made once after a build, and never older than its sources.

Numba keeps machine code beside the sources and renews it when the file of a function changes, but not when
a function that was compiled into it changes in another file. So each state of the sources gets its own cache.
"""

import hashlib
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

from tqdm import tqdm

from shirube_cli.error import CommandError

WARM_UP_PARTS = ('dots', 'search')
"""Of `floor_localizer.core.warm_up`, which are compiled side by side."""
PROGRAMS = (
    *(f'from floor_localizer.core.warm_up import PARTS; PARTS[{part!r}]()' for part in WARM_UP_PARTS),
    'from stereo_landmark.core.warm_up import warm_up; warm_up()',
    'from reward_planner.core.warm_up import warm_up_defaults; warm_up_defaults()',
)
"""Each compiles its share of the loops."""
_COMPILED = re.compile(rb'^@njit', re.MULTILINE)
_IMPORTED = re.compile(rb'^from ([\w.]+) import', re.MULTILINE)


def compile_loops(environment: dict[str, str]) -> None:
    """Let the packages compile their loops, so that whatever uses them starts in seconds from then on.

    Args:
        environment: the one that they will be used in.

    Raises:
        CommandError: the loops cannot be compiled; the messages stand above.
    """
    interval = 0.5 if sys.stderr.isatty() else 10.0
    compilers = [subprocess.Popen([sys.executable, '-c', program], env=environment) for program in PROGRAMS]
    with tqdm(desc='Compiling the loops (once)', bar_format='{desc}: {elapsed}', mininterval=interval) as bar:
        while any(compiler.poll() is None for compiler in compilers):
            bar.update()
            time.sleep(0.2)
    if any(compiler.returncode for compiler in compilers):
        raise CommandError('the loops could not be compiled; the messages stand above')


def digest_loops(sources: Path) -> str:
    """Return a digest of all files with compiled loops and of those that they take constants and loops from.

    Args:
        sources: the folder of the packages.
    """
    wanted = {path for path in sources.glob('*/*/**/*.py') if _COMPILED.search(path.read_bytes())}
    for path in tuple(wanted):
        modules = [name.decode().split('.') for name in _IMPORTED.findall(path.read_bytes())]
        wanted |= {sources.joinpath(parts[0], *parts).with_suffix('.py') for parts in modules}
    digest = hashlib.sha256()
    for path in sorted(path for path in wanted if path.is_file()):
        digest.update(str(path.relative_to(sources)).encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


def fresh_cache(folder: Path, digest: str) -> Path:
    """Return the cache of one state of the sources in a folder, and remove those of other states."""
    cache = folder / digest[:16]
    for other in folder.glob('*'):
        if other != cache:
            shutil.rmtree(other, ignore_errors=True)
    return cache
