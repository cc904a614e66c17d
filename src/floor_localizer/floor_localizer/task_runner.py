"""Where the tasks of an index or a survey run: in this process, in processes of this computer, or on a cluster."""

from __future__ import annotations

import logging
import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from multiprocessing import resource_tracker
from typing import TYPE_CHECKING, Any

from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.independent_tasks import OwnProcess, Task, TaskRunner

if TYPE_CHECKING:
    from distributed import Client

_PATIENCE = 20.0  # with a scheduler that does not answer, or has no workers [s]
_ENVIRONMENT = 'distributed.nanny.pre-spawn-environ'
_WORKERS = {
    # Dask's workers give memory back at once: arrays then take half as much time again.
    f'{_ENVIRONMENT}.MALLOC_TRIM_THRESHOLD_': None,
    # What goes wrong is raised here, and told in one line.
    f'{_ENVIRONMENT}.DASK_LOGGING__DISTRIBUTED': 'critical',
}


class DaskRunner:
    """Runs the tasks on the workers of a dask.distributed client."""

    def __init__(self, client: Client) -> None:
        """Use a client."""
        self._client = client

    def run(self, function: Task, arguments: Sequence[tuple[Any, ...]]) -> Iterator[None]:
        """Call the function with each of the arguments; yield whenever one is done, in any order."""
        from distributed import as_completed  # noqa: PLC0415 as in `task_runner`
        from distributed.scheduler import KilledWorker  # noqa: PLC0415

        futures = [self._client.submit(function, *given, pure=False) for given in arguments]
        try:
            for future in as_completed(futures):
                future.result()
                yield
        except KilledWorker as fault:
            raise FloorLocalizerError(
                'a worker died several times at the same task (is its memory enough?); '
                'give the same command again with fewer --workers: what is done is kept'
            ) from fault
        except CancelledError as fault:
            raise FloorLocalizerError(
                'the scheduler has gone; start it and give the same command again: what is done is kept'
            ) from fault
        finally:
            self._client.cancel(futures)


@contextmanager
def task_runner(workers: int, scheduler: str | None = None) -> Iterator[TaskRunner]:
    """Start what the tasks run on, and end it.

    Args:
        workers: processes of this computer; with one, the tasks run in this process.
        scheduler: address of a dask scheduler whose workers see the same files; None for this computer.

    Raises:
        FloorLocalizerError: the scheduler does not answer, or has no workers.
    """
    if scheduler is None and workers == 1:
        yield OwnProcess()
        return
    # Only index and survey need it, and it takes half a second; it sets its levels of logging when it is imported.
    import distributed  # noqa: F401, PLC0415

    for name in ('distributed', 'distributed.client'):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # as that of the workers
    with _own_workers(workers) if scheduler is None else _workers_of(scheduler) as client:
        yield DaskRunner(client)


@contextmanager
def _own_workers(workers: int) -> Iterator[Client]:
    """Start workers on this computer, and end them."""
    import dask  # noqa: PLC0415 as in `task_runner`
    from distributed import Client, LocalCluster  # noqa: PLC0415

    with dask.config.set(_WORKERS):
        with _interrupts_held():
            cluster = LocalCluster(
                n_workers=workers, threads_per_worker=1, dashboard_address=None, memory_limit=0
            )
        with cluster, Client(cluster) as client:
            yield client


@contextmanager
def _workers_of(scheduler: str) -> Iterator[Client]:
    """Use the workers of a scheduler."""
    from distributed import Client  # noqa: PLC0415 as in `task_runner`

    try:
        client = Client(scheduler, timeout=_PATIENCE)
    except (OSError, ValueError) as fault:
        raise FloorLocalizerError(
            f'--scheduler {scheduler}: does not answer; start "dask scheduler" there, or leave it out'
        ) from fault
    with client:
        try:
            client.wait_for_workers(1, timeout=_PATIENCE)
        except TimeoutError as fault:
            raise FloorLocalizerError(
                f'--scheduler {scheduler}: has no workers; start "dask worker {scheduler}", or leave it out'
            ) from fault
        yield client


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Hold an interrupt back until workers have been started; they inherit that for good.

    A terminal interrupts all its processes: this one ends the workers, which else tell at length that they end.
    """
    resource_tracker.ensure_running()  # else it is started with the first worker, and lets go of what is held
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
