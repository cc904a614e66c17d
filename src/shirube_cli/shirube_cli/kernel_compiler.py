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


def compile_sets(
    sets: Sequence[KernelSet], environment: Mapping[str, str], finish: Callable[[KernelSet], None]
) -> None:
    """Compile kernel sets, so that whatever uses them starts in seconds from then on.

    Args:
        sets: what to compile, the longest first.
        environment: all variables of the compilers; NUMBA_CACHE_DIR names the folder of the machine code.
        finish: called for each set once it is compiled, from any thread.

    Raises:
        CommandError: they cannot be compiled; the messages were printed.
    """
    waiting: SimpleQueue[KernelSet] = SimpleQueue()
    for one in sets:
        waiting.put(one)
    workers = min(len(sets), len(os.sched_getaffinity(0)))
    with Progress('Compiling kernels (once)', sum(one.kernels for one in sets)) as progress:

        def work(_: int) -> bool:
            return _run_worker(waiting, environment, progress, finish)

        with ThreadPoolExecutor(workers) as pool:
            succeeded = list(pool.map(work, range(workers)))
    if not all(succeeded):
        raise CommandError('the kernels could not be compiled, see above; remove the cause and try again')


def _run_worker(
    waiting: 'SimpleQueue[KernelSet]',
    environment: Mapping[str, str],
    progress: Progress,
    finish: Callable[[KernelSet], None],
) -> bool:
    """Let one process compile sets until none is left; return whether it succeeded."""
    command = [sys.executable, '-m', 'shirube_cli.kernel_worker']
    with subprocess.Popen(
        command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        while True:
            try:
                chosen = waiting.get_nowait()
            except Empty:
                break
            try:
                print(chosen.name, file=process.stdin, flush=True)
            except BrokenPipeError:
                return False
            counted = 0
            for line in process.stdout:
                if line.strip() == 'done':
                    break
                counted += 1
                progress.advance(int(counted <= chosen.kernels))
            else:
                return False
            progress.advance(max(chosen.kernels - counted, 0))
            finish(chosen)
        process.stdin.close()
        return process.wait() == 0
