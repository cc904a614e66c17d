"""Machine code of the numba kernels: compiled once for a state of the sources, and never older than they are.

Numba keeps machine code next to the sources and renews it when the file of a function changes, but not when
a function that was compiled into it changes in another file. So each state of the sources gets its own cache.
What colcon installs are copies of the same files, so their machine code is copied, too.
"""

import hashlib
import os
import re
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import Self

from tqdm import tqdm

from shirube_cli.kernel_registry import KERNEL_SETS, KernelSet
from shirube_cli.project import CommandError, is_clone, safe_environment
from shirube_core.files import exclusive_lock

PROGRESS_FILE = 'SHIRUBE_PROGRESS'
"""Environment variable with the file in which the live view finds how far the compilers are."""
_LINE_INTERVAL = 10.0  # time between two lines where the output is not a terminal [s]


class Progress:
    """Counts and shows what is done; to be used in a `with` statement, from any thread."""

    def __init__(self, title: str, total: int) -> None:
        """Prepare to count ``total`` things under a title."""
        self._title, self._total, self._done = title, total, 0
        self._lock = threading.Lock()
        self._bar: tqdm | None = None
        self._next_line = 0.0

    def __enter__(self) -> Self:
        """Show that nothing is done yet."""
        if sys.stderr.isatty():
            # tqdm draws with ASCII characters where the terminal's encoding has no others.
            self._bar = tqdm(desc=self._title, total=self._total, bar_format='{desc}: {n}/{total} |{bar}| {elapsed}')
        else:
            self._print_line()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Show how far it came."""
        if self._bar is not None:
            self._bar.close()
        else:
            self._print_line()

    def advance(self, count: int) -> None:
        """Add things that are done."""
        with self._lock:
            self._done += count
            if file := os.environ.get(PROGRESS_FILE):
                Path(file).write_text(f'{self._title}: {self._done} of {self._total}\n')
            if self._bar is not None:
                self._bar.update(count)
            elif time.monotonic() >= self._next_line:
                self._print_line()

    def _print_line(self) -> None:
        self._next_line = time.monotonic() + _LINE_INTERVAL
        print(f'{self._title}: {self._done} of {self._total}', file=sys.stderr, flush=True)


# Ctrl-C ends a compiler at once, even while it imports numba: a traceback would be of no use.
PROLOGUE = 'import signal; signal.signal(signal.SIGINT, signal.SIG_DFL)'
WORKER = f'{PROLOGUE}; from shirube_cli.kernel_worker import main; raise SystemExit(main())'


def compile_sets(
    sets: Sequence[KernelSet], environment: Mapping[str, str], finish: Callable[[KernelSet], None], worker: str = WORKER
) -> None:
    """Compile kernel sets, the longest first, so that programs that use them start in seconds from then on.

    Args:
        sets: what to compile.
        environment: all variables of the compilers; NUMBA_CACHE_DIR names the folder of the machine code.
        finish: called for each set once it is compiled, from any thread.
        worker: the Python program of a compiler.

    Raises:
        CommandError: they cannot be compiled; the messages were printed.
    """
    waiting: SimpleQueue[KernelSet] = SimpleQueue()
    for one in sets:
        waiting.put(one)
    workers = min(len(sets), len(os.sched_getaffinity(0)))
    with Progress('Compiling kernels (once)', sum(one.kernels for one in sets)) as progress:

        def work(_: int) -> bool:
            command = [sys.executable, '-c', worker]
            with subprocess.Popen(
                command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
            ) as process:
                return _serve(process, waiting, progress, finish)

        with ThreadPoolExecutor(workers) as pool:
            succeeded = list(pool.map(work, range(workers)))
    if not all(succeeded):
        raise CommandError('the kernels could not be compiled, see above; remove the cause and try again')


def _serve(
    process: subprocess.Popen[str],
    waiting: 'SimpleQueue[KernelSet]',
    progress: Progress,
    finish: Callable[[KernelSet], None],
) -> bool:
    """Let a process compile sets until none is left; return whether it succeeded."""
    while not waiting.empty():
        try:
            chosen = waiting.get_nowait()
        except Empty:
            break
        if not _compile_one(chosen, process, progress):
            return False
        finish(chosen)
    process.communicate()
    return process.returncode == 0


def _compile_one(chosen: KernelSet, process: subprocess.Popen[str], progress: Progress) -> bool:
    """Let a process compile a set; return whether it answered until the end."""
    if process.stdin is None or process.stdout is None:
        return False
    try:
        print(chosen.name, file=process.stdin, flush=True)
    except BrokenPipeError:
        return False
    for count, line in enumerate(process.stdout):
        if line.strip() == 'done':
            progress.advance(max(chosen.kernels - count, 0))
            return True
        progress.advance(int(count < chosen.kernels))
    return False


PYTHON = f'python{sys.version_info.major}.{sys.version_info.minor}'
_COMPILED = re.compile(rb'^@njit', re.MULTILINE)
_IMPORTED = re.compile(rb'^from ([\w.]+) import', re.MULTILINE)


def compiled_kernels(root: Path, sets: Sequence[KernelSet] = KERNEL_SETS) -> Path:
    """Return the folder that NUMBA_CACHE_DIR may name, with the kernels of these sets, by default all,
    compiled.

    Raises:
        CommandError: the kernels cannot be compiled; the messages were printed.
    """
    cache = kernel_folder(root)
    with exclusive_lock(cache.parent):
        missing = [one for one in sets if not _mark(cache, one).exists()]
        if missing:
            cache.mkdir(exist_ok=True)
            environment = {**safe_environment(), 'NUMBA_CACHE_DIR': str(cache)}
            compile_sets(missing, environment, lambda one: _mark(cache, one).touch())
    return cache


def are_installed(root: Path, sets: Sequence[KernelSet]) -> bool:
    """Return whether the installed packages have the kernels of these sets, for the sources as they are."""
    if not sets:
        return True
    name = kernel_folder(root).name
    marks = [_installed_mark(root, one) for one in sets]
    return all(mark.is_file() and mark.read_text() == name for mark in marks)


def kernel_folder(root: Path) -> Path:
    """Return the folder for the machine code of the sources as they are; those of other states are removed."""
    # Inside this environment, because numba does not distinguish machine code for another numpy.
    home = Path(sys.prefix) / 'numba'
    if not os.access(sys.prefix, os.W_OK):
        cache = Path(os.environ.get('XDG_CACHE_HOME') or Path.home() / '.cache')
        home = cache / 'shirube' / hashlib.sha256(sys.prefix.encode()).hexdigest()[:16]
    home.mkdir(parents=True, exist_ok=True)
    return fresh_cache(home, digest_kernels(source_folders(root)))


def source_folders(root: Path) -> dict[str, Path]:
    """Return the folders of the packages with kernels by name, in the clone or as pip installed them."""
    names = sorted({each.package for each in KERNEL_SETS} | {'shirube_core', 'scene_simulator'})
    if is_clone(root):
        return {name: root / 'src' / name / name for name in names}
    site = Path(__file__).resolve().parents[1]
    return {name: site / name for name in names}


def copy_to_installed(cache: Path, root: Path, sets: Sequence[KernelSet] = KERNEL_SETS) -> None:
    """Copy the machine code of compiled sets from the folder of ``compiled_kernels`` to what colcon installed."""
    for path in files_with_kernels(root / 'src'):
        package = path.relative_to(root / 'src').parts[0]
        module = path.relative_to(root / 'src' / package)
        copy = root / 'ros2_ws' / 'install' / package / 'lib' / PYTHON / 'site-packages' / module
        if copy.is_file() and copy.read_bytes() == path.read_bytes():
            (copy.parent / '__pycache__').mkdir(exist_ok=True)
            for code in (cache / numba_folder(path)).glob(f'{path.stem}.*.nb[ic]'):
                shutil.copy2(code, copy.parent / '__pycache__')
    for one in sets:
        mark = _installed_mark(root, one)
        mark.parent.mkdir(parents=True, exist_ok=True)
        mark.write_text(cache.name)


def numba_folder(path: Path) -> str:
    """Return the folder in which numba keeps the machine code of a source file below NUMBA_CACHE_DIR."""
    from numba.core.caching import UserProvidedCacheLocator  # noqa: PLC0415 takes half a second

    return str(UserProvidedCacheLocator.get_suitable_cache_subpath(str(path)))


def files_with_kernels(folder: Path) -> Iterator[Path]:
    """Yield the source files below a folder that have kernels, in order."""
    for path in sorted(folder.glob('**/*.py')):
        if 'test' not in path.parts and _COMPILED.search(path.read_bytes()):
            yield path


def digest_kernels(packages: Mapping[str, Path]) -> str:
    """Return a digest of all files with kernels in packages, by name, and of those from which they import."""
    wanted = {path for folder in packages.values() for path in files_with_kernels(folder)}
    for path in tuple(wanted):
        for name in _IMPORTED.findall(path.read_bytes()):
            package, *parts = name.decode().split('.')
            if package in packages and parts:
                wanted.add(packages[package].joinpath(*parts).with_suffix('.py'))
    digest = hashlib.sha256()
    for path in sorted(path for path in wanted if path.is_file()):
        digest.update(str(path).encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


def fresh_cache(folder: Path, digest: str) -> Path:
    """Return the cache of one state of the sources in a folder, and remove those of other states."""
    cache = folder / digest[:16]
    for other in folder.glob('*'):
        if other != cache:
            shutil.rmtree(other, ignore_errors=True)
    return cache


def _mark(cache: Path, one: KernelSet) -> Path:
    """Return the file that is there once a set is compiled."""
    return cache / f'{one.name}.compiled'


def _installed_mark(root: Path, one: KernelSet) -> Path:
    """Return the file that names the cache from which a set was copied to the installed packages."""
    return root / 'ros2_ws' / 'install' / '.kernels' / one.name
