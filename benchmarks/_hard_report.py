"""The table of hard pictures."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from _pose_scores import EXACT_WITHIN, PoseScore, percent, verdicts, whitened_rms
from numpy.typing import NDArray


@dataclass
class HardOutcome:
    """What came of one condition.

    Attributes:
        name: name of the condition.
        scores: scores without a prior.
        tracked: scores with a prior.
        example: the first picture with its dots, shape (h, w, 3).
    """

    name: str
    scores: list[PoseScore] = field(default_factory=list)
    tracked: list[PoseScore] = field(default_factory=list)
    example: NDArray[np.uint8] = field(default_factory=lambda: np.zeros((1, 1, 3), dtype=np.uint8))


def hard_table(outcomes: Sequence[HardOutcome]) -> str:
    """Return the table and, below, the counts of wrong poses and the reasons for none."""
    head = (
        '| condition | right / none / wrong % | exact % | tracked: right / none / wrong % | exact % '
        '| error mm: median / 95 % | ° | error / stated: alone, tracked | why none |'
    )
    wrong = sum(score.verdict == 'wrong' for o in outcomes for score in (*o.scores, *o.tracked))
    total = sum(len(o.scores) + len(o.tracked) for o in outcomes)
    return '\n'.join([head, '|---' * 9 + '|', *map(_row, outcomes), f'\nWrong poses: {wrong} of {total}.'])


def _row(outcome: HardOutcome) -> str:
    right = [score for score in outcome.scores if score.verdict == 'right']
    ratios = (whitened_rms(scores)[3] for scores in (outcome.scores, outcome.tracked))
    reasons = Counter(score.reason for score in outcome.scores if score.reason)
    return (
        f'| {outcome.name} | {verdicts(outcome.scores)} | {_fraction_exact(outcome.scores)} '
        f'| {verdicts(outcome.tracked)} | {_fraction_exact(outcome.tracked)} '
        f'| {_spread([1e3 * score.distance for score in right])} '
        f'| {_spread([math.degrees(score.turn) for score in right])} '
        f'| {", ".join(format(ratio, ".2f") for ratio in ratios)} '
        f'| {", ".join(f"{count} x {reason}" for reason, count in reasons.most_common()) or "–"} |'
    )


def _fraction_exact(scores: Sequence[PoseScore]) -> str:
    return percent(sum(score.distance < EXACT_WITHIN for score in scores) / len(scores))


def _spread(values: Sequence[float]) -> str:
    if not values:
        return '–'
    return ' / '.join(format(value, '.3f') for value in np.percentile(values, [50, 95]))
