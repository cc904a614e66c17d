"""Where the tasks of an index or a survey run: in this process, in processes of this computer, or on a cluster."""

from __future__ import annotations

import logging
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from multiprocessing import resource_tracker
from typing import Any

from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.independent_tasks import OwnProcess, Task, TaskRunner

_PATIENCE = 20.0  # with a scheduler that does not answer [s]
_ENVIRONMENT = 'distributed.nanny.pre-spawn-environ'
_WORKERS = {
    # Dask's workers give memory back at once: arrays then take half as much time again.
    f'{_ENVIRONMENT}.MALLOC_TRIM_THRESHOLD_': None,
    # What goes wrong is raised here, and told in one line.
    f'{_ENVIRONMENT}.DASK_LOGGING__DISTRIBUTED': 'critical',
}


class DaskRunner:
    """Runs the tasks on the workers of a dask.distributed client."""

    def __init__(self, client: Any) -> None:
        """Use a ``distributed.Client``."""
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
        finally:
            self._client.cancel(futures)


@contextmanager
def task_runner(workers: int, scheduler: str | None = None) -> Iterator[TaskRunner]:
    """Start what the tasks run on, and end it.

    Args:
        workers: processes of this computer; with one, the tasks run in this process.
        scheduler: address of a dask scheduler whose workers see the same files; None for this computer.

    Raises:
        FloorLocalizerError: the scheduler does not answer.
    """
    if scheduler is None and workers == 1:
        yield OwnProcess()
        return
    # Only index and survey need it, and it takes half a second to import.
    import dask  # noqa: PLC0415
    from distributed import Client, LocalCluster  # noqa: PLC0415

    if scheduler is None:
        with dask.config.set(_WORKERS):
            with _interrupts_held():
                cluster = LocalCluster(
                    n_workers=workers, threads_per_worker=1, dashboard_address=None, memory_limit=0,
                    silence_logs=logging.CRITICAL,
                )  # fmt: skip
            with cluster, Client(cluster) as client:
                yield DaskRunner(client)
        return
    try:
        client = Client(scheduler, timeout=_PATIENCE)
    except (OSError, ValueError) as fault:
        raise FloorLocalizerError(
            f'--scheduler {scheduler}: does not answer; start "dask scheduler" there, or leave it out'
        ) from fault
    with client:
        yield DaskRunner(client)


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
