"""What several commands share: options generated from a settings class, and workers for tasks."""

from __future__ import annotations

import argparse
import logging
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from importlib.util import find_spec
from multiprocessing import get_context, parent_process, resource_tracker
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.independent_tasks import InProcessRunner, Task, TaskRunner
from floor_localizer.files.array_file import DISK_FULL_ERRORS
from shirube_core import command
from shirube_core.geometry import CameraMount
from shirube_core.settings import SettingsError
from shirube_ros.errors import CameraFileError

Settings = TypeVar('Settings')
_SCHEDULER_TIMEOUT = 20.0  # timeout of a scheduler that does not answer or has no workers [s]
# Dask's event loop logs a traceback if an interrupt arrives between two of its own steps.
_LOGGERS_OF_DASK = ('distributed', 'distributed.client', 'tornado.application', 'asyncio')
# One thread a worker, which the libraries read when they are loaded.
_WORKER_ENVIRONMENT = dict.fromkeys(('MKL_NUM_THREADS', 'OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS'), '1')
_WORKER_DIED = '{} (not enough memory?); run the same command again with fewer --workers: completed tasks are kept'


def run_command(
    name: str, job: Callable[[], None], out: Path | None = None, errors: tuple[type[Exception], ...] = ()
) -> int:
    """Run a command; return 0, or 1 after one line about what is wrong with a file or an option.

    ``out`` is named for errors of the system without a file, ``errors`` are further ones whose message is the line.
    """
    return command.run_command(name, job, (FloorLocalizerError, CameraFileError, SettingsError, *errors), out)


def run_resumable(name: str, job: Callable[[], None], out: Path, errors: tuple[type[Exception], ...] = ()) -> int:
    """Run a command that keeps its completed tasks, as `run_command`; return 130 when it is interrupted."""

    def work() -> None:
        try:
            job()
        except BlockingIOError as fault:
            reason = 'another survey is running there; wait for its end or choose another --out'
            raise FloorLocalizerError(f'{out}: {reason}') from fault
        except OSError as fault:
            if fault.errno not in DISK_FULL_ERRORS:
                raise
            remedy = 'free some and give the same command again: completed tasks are kept'
            raise FloorLocalizerError(f'{fault.filename or out}: disk full: {fault.strerror}; {remedy}') from fault

    try:
        return run_command(name, work, out, errors)
    except KeyboardInterrupt:
        print(f'\n{name}: interrupted; give the same command again to resume', file=sys.stderr)
        return 130


def add_mount_options(parser: argparse.ArgumentParser, xyz_help: str, rpy_help: str) -> None:
    """Add ``--camera-xyz`` and ``--camera-rpy``, the mount of the camera."""
    mount = CameraMount()
    for name, default, letters, text in (
        ('--camera-xyz', mount.xyz, ('X', 'Y', 'Z'), xyz_help),
        ('--camera-rpy', mount.rpy, ('R', 'P', 'Y'), rpy_help),
    ):
        parser.add_argument(name, type=float, nargs=3, default=default, metavar=letters, help=text)


def add_worker_options(parser: argparse.ArgumentParser) -> None:
    """Add ``--workers`` and ``--scheduler``, the arguments of `task_runner`."""
    parser.add_argument(
        '--workers', type=_positive, default=os.cpu_count() or 1, help='number of local processes (default: all cores)'
    )
    parser.add_argument(
        '--scheduler',
        metavar='ADDRESS',
        help='address of a dask scheduler, such as tcp://10.0.0.1:8786, whose workers access the same files',
    )


def _positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError('must be at least 1')
    return number


if TYPE_CHECKING:
    from distributed import Client


class ProcessRunner:
    """Runs the tasks in processes of this computer, which stay until `stop`."""

    def __init__(self, workers: int) -> None:
        """Set the number of processes, which are started with the first tasks."""
        self._workers = workers
        self._pool: ProcessPoolExecutor | None = None

    def run(self, function: Task, arguments: Sequence[tuple[Any, ...]]) -> Iterator[None]:
        """Call the function with each of the arguments; yield after each completed task, in any order."""
        if self._pool is None:
            # A fork would copy the locks of this process's threads.
            self._pool = ProcessPoolExecutor(self._workers, get_context('spawn'), _end_with_parent)
        with _worker_environment(), _block_interrupts():
            futures = [self._pool.submit(function, *given) for given in arguments]
        try:
            for future in as_completed(futures):
                future.result()
                yield
        except BrokenProcessPool as fault:
            self.stop()
            raise FloorLocalizerError(_WORKER_DIED.format('a worker died')) from fault
        finally:
            for future in futures:
                future.cancel()

    def stop(self) -> None:
        """End the processes after their current tasks."""
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)
        self._pool = None


def _end_with_parent() -> None:
    """End this worker with the process that started it, even if that was killed."""

    def wait() -> None:
        if (parent := parent_process()) is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


class DaskRunner:
    """Runs the tasks on the workers of a dask.distributed client."""

    def __init__(self, client: Client) -> None:
        """Store the client."""
        self._client = client

    def run(self, function: Task, arguments: Sequence[tuple[Any, ...]]) -> Iterator[None]:
        """Call the function with each of the arguments; yield after each completed task, in any order."""
        from distributed import as_completed as clients_completed  # noqa: PLC0415 as in `_scheduler_workers`
        from distributed.scheduler import KilledWorker  # noqa: PLC0415

        futures = [self._client.submit(function, *given, pure=False) for given in arguments]
        try:
            for future in clients_completed(futures):
                future.result()
                yield
        except KilledWorker as fault:
            message = _WORKER_DIED.format('a worker died several times at the same task')
            raise FloorLocalizerError(message) from fault
        except CancelledError as fault:
            raise FloorLocalizerError(
                'the scheduler has stopped; start it and run the same command again: completed tasks are kept'
            ) from fault
        finally:
            self._client.cancel(futures)


@contextmanager
def task_runner(workers: int, scheduler: str | None = None) -> Iterator[TaskRunner]:
    """Start a task runner, and stop it at the end.

    Args:
        workers: number of local processes; with one, the tasks run in this process.
        scheduler: address of a dask scheduler whose workers access the same files; None for local processes.

    Raises:
        FloorLocalizerError: the scheduler does not answer or has no workers, or dask is not installed.
    """
    if scheduler is None and workers == 1:
        yield InProcessRunner()
        return
    if scheduler is not None:
        with _scheduler_workers(scheduler) as client:
            yield DaskRunner(client)
        return
    runner = ProcessRunner(workers)
    try:
        yield runner
    finally:
        runner.stop()


@contextmanager
def _scheduler_workers(scheduler: str) -> Iterator[Client]:
    """Connect to the workers of a scheduler."""
    if find_spec('distributed') is None:
        raise FloorLocalizerError(
            '--scheduler: needs dask; install it with "pip install dask distributed", or leave the option out'
        )
    # Imported here, as it takes half a second and only a cluster needs it; the import sets its logging levels.
    from distributed import Client  # noqa: PLC0415

    for name in _LOGGERS_OF_DASK:
        logging.getLogger(name).setLevel(logging.CRITICAL)  # errors are raised here and reported in one line
    try:
        client = Client(scheduler, timeout=_SCHEDULER_TIMEOUT)
    except (OSError, ValueError) as fault:
        raise FloorLocalizerError(
            f'--scheduler {scheduler}: does not answer; start "dask scheduler" there, or leave it out'
        ) from fault
    with client:
        try:
            client.wait_for_workers(1, timeout=_SCHEDULER_TIMEOUT)
        except TimeoutError as fault:
            raise FloorLocalizerError(
                f'--scheduler {scheduler}: has no workers; start "dask worker {scheduler}", or leave it out'
            ) from fault
        yield client


@contextmanager
def _worker_environment() -> Iterator[None]:
    """Set the environment that workers inherit; this process keeps its own."""
    missing = _WORKER_ENVIRONMENT.keys() - os.environ.keys()
    os.environ.update({name: _WORKER_ENVIRONMENT[name] for name in missing})
    try:
        yield
    finally:
        for name in missing:
            del os.environ[name]


@contextmanager
def _block_interrupts() -> Iterator[None]:
    """Block SIGINT while workers are started; they inherit the blocked signal.

    A terminal sends SIGINT to all its processes. Only this process handles it and stops the workers, which otherwise
    would print tracebacks; it handles it at the end, as a worker that is half started prints one, too.
    """
    resource_tracker.ensure_running()  # otherwise started with the first worker, which would unblock the signal
    previous_mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    # Another thread, of a library, may get the signal: its handler would run here all the same.
    is_main, arrived = threading.current_thread() is threading.main_thread(), list[int]()
    handler = signal.signal(signal.SIGINT, lambda number, _: arrived.append(number)) if is_main else None
    try:
        yield
    finally:
        if is_main:
            signal.signal(signal.SIGINT, handler)
        signal.pthread_sigmask(signal.SIG_SETMASK, previous_mask)
        if arrived:
            signal.raise_signal(signal.SIGINT)
