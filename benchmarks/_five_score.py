"""Counts what the methods answer to the views of five meters, and prints it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass, field

import numpy as np
from _five_views import DECIDABLE, OUT_OF_VIEW, UNDECIDABLE, Lesson, MeterView

from shirube_core.geometry import SE2

AMBIGUOUS = 'ambiguous: several poses match'
RIGHT, MISTAKEN, NONE = 'found', 'mistaken', 'none'
OURS = 'shirube'
HEADERS = (
    *('gaps, surroundings', 'views', 'decidable', 'found', 'mistaken', 'ambiguous', 'no pose'),
    *('not decidable', 'found', 'mistaken', 'ambiguous', 'no pose'),
    *('too little in view', 'found', 'mistaken', 'no pose'),
)
METHOD_HEADERS = (
    *('method', 'decidable', 'found', 'mistaken', 'no pose', 'others', 'found', 'mistaken', 'no pose'),
    *('position mm: median / 95 %', 'heading °: median / 95 %'),
)


@dataclass
class Score:
    """Answers to the views of one condition.

    Attributes:
        answers: how many by method, standing of the view and verdict.
        errors: position [m] and heading [rad] of what each method found.
        failures: failures of shirube: each mistake and each decidable view without a pose.
        untaught: why corridors could not be taught.
    """

    answers: Counter[tuple[str, str, str]] = field(default_factory=Counter)
    errors: dict[str, list[tuple[float, float]]] = field(default_factory=dict)
    failures: list[str] = field(default_factory=list)
    untaught: list[str] = field(default_factory=list)

    def add(self, method: str, lesson: Lesson, view: MeterView, found: SE2 | str | None) -> None:
        """Add an answer: a pose, or why there is none."""
        if isinstance(found, SE2):
            error = found.distance_to(view.T_lesson_base)
            verdict = MISTAKEN if error > 0.5 * lesson.spacing else RIGHT
            if verdict == RIGHT:
                turn = abs(found.yaw_to(view.T_lesson_base))
                self.errors.setdefault(method, []).append((error, turn))
        else:
            verdict = found or NONE
        self.answers[method, view.status, verdict] += 1
        if method == OURS and verdict != RIGHT and (verdict == MISTAKEN or view.status == DECIDABLE):
            self.failures.append(_case(lesson, view, verdict))

    def count(self, method: str, statuses: Collection[str], verdicts: Collection[str] | None = None) -> int:
        """Return how many answers there are of a method to views of some standings; None for all verdicts."""
        return sum(
            count
            for (who, where, what), count in self.answers.items()
            if who == method and where in statuses and (verdicts is None or what in verdicts)
        )


def merge(scores: Collection[Score]) -> Score:
    """Return all answers of some scores."""
    total = Score()
    for score in scores:
        total.answers += score.answers
        total.failures += score.failures
        total.untaught += score.untaught
        for method, errors in score.errors.items():
            total.errors.setdefault(method, []).extend(errors)
    return total


def print_scores(scores: dict[str, Score]) -> None:
    """Print the tables and the failures."""
    total = merge(scores.values())
    print(_row(HEADERS), '|---' * len(HEADERS) + '|', sep='\n')
    for name, score in (*scores.items(), ('**all**', total)):
        print(_row(_cells_of_condition(name, score)))
    print('', _row(METHOD_HEADERS), '|---' * len(METHOD_HEADERS) + '|', sep='\n')
    for method in dict.fromkeys(method for method, _, _ in total.answers):
        print(_row(_cells_of_method(method, total)))
    print(f'\nCorridors that could not be taught: {len(total.untaught)}.')
    for line in (*total.untaught, *total.failures):
        print(f'- {line}')


def _row(cells: Collection[str]) -> str:
    return f'| {" | ".join(cells)} |'


def _cells_of_condition(name: str, score: Score) -> list[str]:
    cells = [name, str(score.count(OURS, (DECIDABLE, UNDECIDABLE, OUT_OF_VIEW)))]
    for status in (DECIDABLE, UNDECIDABLE, OUT_OF_VIEW):
        views = score.count(OURS, (status,))
        parts = [score.count(OURS, (status,), (verdict,)) for verdict in (RIGHT, MISTAKEN, AMBIGUOUS)]
        if status == OUT_OF_VIEW:
            parts.pop()
        found = str(parts[0])
        if status == DECIDABLE:
            found += f' ({100.0 * parts[0] / max(views, 1):.1f} %)'
        cells += [str(views), found, *(str(part) for part in parts[1:]), str(views - sum(parts))]
    return cells


def _cells_of_method(method: str, score: Score) -> list[str]:
    cells = [method]
    for statuses in ((DECIDABLE,), (UNDECIDABLE, OUT_OF_VIEW)):
        views = score.count(method, statuses)
        found, mistaken = (score.count(method, statuses, (verdict,)) for verdict in (RIGHT, MISTAKEN))
        cells += [str(each) for each in (views, found, mistaken, views - found - mistaken)]
    if method not in score.errors:
        return [*cells, '-', '-']
    position, heading = np.quantile(score.errors[method], (0.5, 0.95), axis=0).T
    heading = np.degrees(heading)
    return [
        *cells,
        f'{1e3 * position[0]:.1f} / {1e3 * position[1]:.1f}',
        f'{heading[0]:.3f} / {heading[1]:.3f}',
    ]


def _case(lesson: Lesson, view: MeterView, verdict: str) -> str:
    pose, design = view.T_lesson_base, lesson.design
    kind = f'{"even" if design.even else "uneven"}{", bare" if design.bare else ""}'
    hidden = 'nothing' if view.hidden is None else f'meter {view.hidden}'
    taught = f'taught {lesson.chosen[0]} to {lesson.chosen[-1]}'
    place = f'({pose.x:+.2f} m, {pose.y:+.2f} m, {np.degrees(pose.yaw):+.0f}°)'
    return f'{verdict}: corridor {design.seed} ({kind}; {taught}), {hidden} hidden, at {place}'
