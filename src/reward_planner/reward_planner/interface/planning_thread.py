"""Runs planning cycles in threads, so that the control cycle never waits for a route."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

from reward_planner.core.driving.route_planning import run_at_once

_THREADS = 2  # the route to a new goal does not wait for that to the previous one

Result = TypeVar('Result')


class PlanningThread:
    """Starts threads with the first work and ends them with `end`."""

    def __init__(self, *, is_used: bool) -> None:
        """Start without threads; if they are not used, work is done at once."""
        self._is_used = is_used
        self._executor: ThreadPoolExecutor | None = None

    def run(self, work: Callable[[], Result]) -> Future[Result]:
        """Run a function in a thread."""
        if not self._is_used:
            return run_at_once(work)
        if self._executor is None:
            self._executor = ThreadPoolExecutor(_THREADS, thread_name_prefix='planning')
        return self._executor.submit(work)

    def end(self) -> None:
        """End the threads after their present work, without waiting."""
        if self._executor is not None:
            self._executor.shutdown(wait=False, cancel_futures=True)
            self._executor = None
