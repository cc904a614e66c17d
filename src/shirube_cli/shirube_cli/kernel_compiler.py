"""Compiles kernel sets in as many processes as there are cores, and shows how many kernels are done."""

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import Self

from tqdm import tqdm

from shirube_cli.kernel_registry import KernelSet
from shirube_cli.project import CommandError

PROGRESS_FILE = 'SHIRUBE_PROGRESS'
"""Environment variable with the file in which the live view finds how far the compilers are."""
_LINE_INTERVAL = 10.0
"""Time between two lines where the output is not a terminal [s]."""


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
