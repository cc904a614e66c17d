"""Machine code of the compiled loops: made once for a state of the sources, and never older than they are.

Numba keeps machine code beside the sources and renews it when the file of a function changes, but not when
a function that was compiled into it changes in another file. So each state of the sources gets its own cache.
What colcon installs are copies of the same files, so their machine code is copied, too.
"""

import hashlib
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from tqdm import tqdm

from shirube_cli.error import CommandError
from shirube_cli.project import find_root, safe_environment
from shirube_files import locked

WARM_UPS = (
    (
        'from floor_localizer.core.warm_up import warm_up',
        'from shirube_mission.warm_up import warm_up',
        'from reward_planner.core.warm_up import warm_up_defaults as warm_up',
    ),
    (
        'from stereo_landmark.core.warm_up import warm_up',
        'from vlc_beacon.core.receiver.warm_up import warm_up_both as warm_up',
    ),
)
"""Two shares of the loops that take about as long: what numba itself is made of is compiled once a process."""
# A compiler makes millions of objects that stay; the collector would look through them again and again for nothing.
# Ctrl-C ends a compiler at once: its traceback would tell the user nothing.
PROLOGUE = """
import gc, signal
gc.set_threshold(50_000, 20, 50)
signal.signal(signal.SIGINT, signal.SIG_DFL)
"""
PROGRAMS = tuple(PROLOGUE + '\n'.join(f'{one}\nwarm_up()' for one in share) for share in WARM_UPS)
PYTHON = f'python{sys.version_info.major}.{sys.version_info.minor}'
_COMPILED = re.compile(rb'^@njit', re.MULTILINE)
_IMPORTED = re.compile(rb'^from ([\w.]+) import', re.MULTILINE)
_COMPLETE = 'complete'


def compiled_loops(root: Path) -> Path:
    """Return the folder that NUMBA_CACHE_DIR may name: all loops of the sources, compiled if they were not.

    Args:
        root: the repository.

    Raises:
        CommandError: the loops cannot be compiled; the messages stand above.
    """
    cache = loops_folder(root)
    with locked(cache.parent):
        if not (cache / _COMPLETE).exists():
            compile_loops({**safe_environment(), 'NUMBA_CACHE_DIR': str(cache)})
            cache.mkdir(exist_ok=True)
            (cache / _COMPLETE).touch()
    return cache


def loops_folder(root: Path) -> Path:
    """Return the folder for the machine code of the sources as they are, complete or not; those of others go."""
    # Of this environment, because numba does not tell machine code for another numpy apart.
    home = Path(sys.prefix) / 'numba'
    home.mkdir(exist_ok=True)
    return fresh_cache(home, digest_loops(root / 'src'))


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


def put_beside_installed(cache: Path, root: Path) -> None:
    """Copy the machine code of the sources to what colcon installed from them.

    Args:
        cache: from ``compiled_loops``.
        root: the repository.
    """
    for path in files_with_loops(root / 'src'):
        package = path.relative_to(root / 'src').parts[0]
        module = path.relative_to(root / 'src' / package)
        copy = root / 'ros2_ws' / 'install' / package / 'lib' / PYTHON / 'site-packages' / module
        if copy.is_file() and copy.read_bytes() == path.read_bytes():
            (copy.parent / '__pycache__').mkdir(exist_ok=True)
            for code in (cache / numba_folder(path)).glob(f'{path.stem}.*.nb[ic]'):
                shutil.copy2(code, copy.parent / '__pycache__')


def numba_folder(path: Path) -> str:
    """Return the folder in which numba keeps the machine code of a source file below NUMBA_CACHE_DIR."""
    from numba.core.caching import UserProvidedCacheLocator  # noqa: PLC0415 takes half a second

    return str(UserProvidedCacheLocator.get_suitable_cache_subpath(str(path)))


def files_with_loops(folder: Path) -> Iterator[Path]:
    """Yield the source files below a folder that have compiled loops, in order."""
    for path in sorted(folder.glob('**/*.py')):
        if 'test' not in path.parts and _COMPILED.search(path.read_bytes()):
            yield path


def digest_loops(sources: Path) -> str:
    """Return a digest of all files with compiled loops and of those that they take constants and loops from.

    Args:
        sources: the folder of the packages.
    """
    wanted = set(files_with_loops(sources))
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


def main() -> None:
    """Compile what is not compiled, and put it beside what is installed."""
    os.environ.pop('NUMBA_CACHE_DIR', None)
    root = find_root()
    put_beside_installed(compiled_loops(root), root)


if __name__ == '__main__':
    main()
