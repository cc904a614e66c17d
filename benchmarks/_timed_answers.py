"""Answers with their times, and what they come to."""

from __future__ import annotations

import math
import os
import time
from collections import Counter
from collections.abc import Callable
from typing import NamedTuple, TypeVar

import cv2
import numpy as np

from shirube_core.geometry import SE2

RIGHT_WITHIN = 0.002
RIGHT_TURN = math.radians(1.5)

Seen = TypeVar('Seen')


class TimedAnswer(NamedTuple):
    """One answer.

    Attributes:
        verdict: 'right' (within 2 mm and 1.5 degrees), 'wrong' or 'none'.
        seconds: processor time to the answer.
    """

    verdict: str
    seconds: float


def use_one_core() -> None:
    """Keep this process on one core."""
    if hasattr(os, 'sched_setaffinity'):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    cv2.setNumThreads(1)


def time_answer(locate: Callable[[Seen], SE2 | None], seen: Seen, truth: SE2) -> TimedAnswer:
    """Ask for the pose of what is seen."""
    begin = time.process_time()
    found = locate(seen)
    seconds = time.process_time() - begin
    if found is None:
        return TimedAnswer('none', seconds)
    right = found.distance_to(truth) <= RIGHT_WITHIN and abs(found.yaw_to(truth)) <= RIGHT_TURN
    return TimedAnswer('right' if right else 'wrong', seconds)


def time_quantiles(answers: list[TimedAnswer]) -> tuple[float, float]:
    """Return the median and the 95th percentile of the times [ms]; an answer without a pose counts with its time."""
    median, high = np.percentile([1e3 * answer.seconds for answer in answers], [50, 95])
    return float(median), float(high)


def outcome_rates(answers: list[TimedAnswer]) -> str:
    """Return how many are right, none and wrong."""
    count = Counter(answer.verdict for answer in answers)
    return ' / '.join(str(count[verdict]) for verdict in ('right', 'none', 'wrong'))
