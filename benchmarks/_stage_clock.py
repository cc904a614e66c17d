"""CPU time of the stages of a method: functions are temporarily replaced by timed wrappers."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any


@contextmanager
def time_stages(stages: Mapping[str, tuple[object, str]]) -> Iterator[dict[str, float]]:
    """Count the processor time of functions by the name of their stage [ms].

    Args:
        stages: where each function is looked up by its caller: a module or class, and the name there. What a clocked
            function calls that is clocked, too, counts for the inner one only.
    """
    spent = dict.fromkeys(stages, 0.0)
    inner: list[float] = [0.0]

    def time_call(stage: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def run(*args: Any, **options: Any) -> Any:
            inner.append(0.0)
            begin = time.process_time()
            answer = function(*args, **options)
            whole = 1e3 * (time.process_time() - begin)
            spent[stage] += whole - inner.pop()
            inner[-1] += whole
            return answer

        return run

    originals = {stage: getattr(owner, name) for stage, (owner, name) in stages.items()}
    for stage, (owner, name) in stages.items():
        setattr(owner, name, time_call(stage, originals[stage]))
    try:
        yield spent
    finally:
        for stage, (owner, name) in stages.items():
            setattr(owner, name, originals[stage])
