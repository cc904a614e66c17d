"""Compiles kernel sets in as many processes as there are cores, and shows how many kernels are done."""

import os
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from queue import Empty, SimpleQueue

from shirube_cli.error import CommandError
from shirube_cli.kernel_registry import KernelSet
from shirube_cli.progress import Progress

# Ctrl-C ends a compiler at once, even while it imports numba: a traceback would be of no use.
PROLOGUE = 'import signal; signal.signal(signal.SIGINT, signal.SIG_DFL)'
WORKER = f'{PROLOGUE}; from shirube_cli.kernel_worker import main; raise SystemExit(main())'


def compile_sets(
    sets: Sequence[KernelSet],
    environment: Mapping[str, str],
    finish: Callable[[KernelSet], None],
    worker: str = WORKER,
) -> None:
    """Compile kernel sets, so that programs that use them start in seconds from then on.

    Args:
        sets: what to compile, the longest first.
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
