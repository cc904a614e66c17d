"""Runners of tasks that behave like a cluster, or die."""

import math
import pickle
from collections.abc import Iterator, Sequence
from typing import Any

from floor_localizer.core.independent_tasks import InProcessRunner, Task


class Elsewhere:
    """Runs pickled copies of the tasks, of at most some bytes, in reverse order, as other processes may do."""

    def __init__(self, most_bytes: float = math.inf) -> None:
        self.most_bytes = most_bytes

    def run(self, function: Task, arguments: Sequence[tuple[Any, ...]]) -> Iterator[None]:
        for given in reversed(arguments):
            text = pickle.dumps((function, given))
            assert len(text) < self.most_bytes
            copy, copied = pickle.loads(text)
            copy(*copied)
            yield


class Dying:
    """Exits after some tasks."""

    def __init__(self, tasks: int) -> None:
        self.left = tasks

    def run(self, function: Task, arguments: Sequence[tuple[Any, ...]]) -> Iterator[None]:
        for _ in InProcessRunner().run(function, arguments):
            self.left -= 1
            if self.left <= 0:
                raise SystemExit
            yield
