"""Tasks that do not depend on each other; here, one after the other. `task_runner` has them run elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol

Task = Callable[..., Any]


class TaskRunner(Protocol):
    """Runs tasks that do not depend on each other."""

    def run(self, function: Task, arguments: Sequence[tuple[Any, ...]]) -> Iterator[None]:
        """Call the function with each of the arguments; yield whenever one is done, in any order."""
        ...


class OwnProcess:
    """Runs the tasks one after the other."""

    def run(self, function: Task, arguments: Sequence[tuple[Any, ...]]) -> Iterator[None]:
        """Call the function with each of the arguments; yield whenever one is done."""
        for given in arguments:
            function(*given)
            yield


def run_numbered(runner: TaskRunner, task: Callable[[int], None], count: int, batch: int = 1) -> None:
    """Call a task with each number from 0 on.

    Args:
        runner: of the calls.
        task: takes the number; other processes may be given it, so it is small and can be pickled.
        count: how many numbers there are.
        batch: so many follow each other in one process: small ones take less time than to be handed out.
    """
    calls = [(task, first, min(first + batch, count)) for first in range(0, count, batch)]
    for _ in runner.run(_call, calls):
        pass


def _call(task: Callable[[int], None], first: int, last: int) -> None:
    for number in range(first, last):
        task(number)
