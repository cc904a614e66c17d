"""Independent tasks and a runner in this process; `task_runner` starts runners with several processes."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol

Task = Callable[..., Any]


class TaskRunner(Protocol):
    """Runs independent tasks."""

    def run(self, function: Task, arguments: Sequence[tuple[Any, ...]]) -> Iterator[None]:
        """Call the function with each tuple of arguments; yield after each finished call, in any order."""
        ...


class InProcessRunner:
    """Runs the tasks one after the other in this process."""

    def run(self, function: Task, arguments: Sequence[tuple[Any, ...]]) -> Iterator[None]:
        """Call the function with each tuple of arguments; yield after each call."""
        for given in arguments:
            function(*given)
            yield


def run_indexed(runner: TaskRunner, task: Callable[[int], None], count: int, batch: int = 1) -> None:
    """Call a task with each number from 0 to ``count`` - 1; ``batch`` calls at once reduce the overhead of scheduling.

    The task should be small and must be picklable, as it is sent to other processes.
    """
    calls = [(task, first, min(first + batch, count)) for first in range(0, count, batch)]
    for _ in runner.run(_run_range, calls):
        pass


def _run_range(task: Callable[[int], None], first: int, last: int) -> None:
    for number in range(first, last):
        task(number)
