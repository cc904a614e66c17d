"""The paper's tables 2 to 5 and its two failed cases again, on its conditions, with its figures.

    shirube bench paper_tables
    shirube bench paper_tables --matcher pole_star --places 100 --tables 4

Table 5 compares the paper's match rate (2.3.3) of right poses with that of the best wrong candidate over the
cells of table 4. Wrong candidates are the poses of the pole-star pipeline more than 20 mm from the truth,
taken or not, at every tenth place; the paper counts only those that were taken.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np
from _figures import count, error, outcomes, percent, time
from _harness import Option, Run, cpu_time, in_processes, run_benchmark
from _paper_matchers import MATCHERS, view_points
from _paper_views import CAMERA, FLOOR_SIZE, MOUNT, NOISE, PaperView, paper_floor, paper_views, spread_places
from _pose_scores import verdict_of
from numpy.typing import NDArray
from scipy.spatial import KDTree
from scipy.spatial.distance import pdist

from floor_localizer.core.acceptance import log_chance_alignments
from floor_localizer.core.pole_star.match_rate import build_address_matrix, match_rate
from floor_localizer.core.pole_star.pole_star_matcher import PoleStarMatcher
from floor_localizer.core.pole_star.settings import PoleStarSettings
from floor_localizer.core.settings import LocalizerSettings

# The pole-star pipeline, which names the wrong candidates, takes most of the time: it is asked this seldom.
RUNNERS_UP_EVERY = 10
# A candidate nearer to the truth than this [m] is the truth, ill fitted, and no rival of it.
ELSEWHERE = 0.02
CHANCE_MAX = 1e-3
RATES = (0.1, 0.2, 0.3, 0.4, 0.5)


class Cell(NamedTuple):
    """One column of a table of the paper: rates of missing and spurious dots, its figures, and ours to find."""

    missing: float
    spurious: float
    paper: str
    places: int = 1209


# Right / wrong / none in percent. The paper prints 95.54 at 40 % in table 4; its row adds up with 94.54.
TABLES = {
    '2': [
        Cell(0.0, rate, paper)
        for rate, paper in zip(
            RATES, (*['100 / 0 / 0'] * 3, '99.59 / 0.33 / 0.08', '99.26 / 0.66 / 0.08'), strict=True
        )
    ],
    '3': [
        Cell(0.1, 0.0, '100 / 0 / 0'),
        Cell(0.2, 0.0, '99.92 / 0 / 0.08'),
        Cell(0.3, 0.0, '99.59 / 0.17 / 0.29'),
        Cell(0.4, 0.0, '99.5 / 0.08 / 0.41'),
        Cell(0.5, 0.0, '95.95 / 0.91 / 3.14'),
    ],
    '4': [
        Cell(0.25, 0.1, '99.57 / 0.08 / 0.33'),
        Cell(0.25, 0.2, '98.76 / 0.50 / 0.74'),
        Cell(0.25, 0.3, '97.35 / 1.41 / 1.24'),
        Cell(0.25, 0.4, '94.54 / 3.39 / 2.07'),
        Cell(0.25, 0.5, '89.66 / 7.44 / 2.90'),
    ],
    'failed': [Cell(0.146, 0.902, 'failed (fig. 28)', 1000), Cell(0.81, 0.095, 'failed (fig. 30)', 1000)],
}
TABLE_5_PAPER = ('61.1 / 10.0', '56.3 / 16.1', '51.5 / 23.5', '38.9 / 18.9', '42.9 / 21.4')


class Score(NamedTuple):
    """One answer against the truth.

    Attributes:
        verdict: 'right', 'wrong' or 'none'.
        reason: why there is no pose.
        position_error: distance from the true place, NaN without a pose [m].
        heading_error: turn from the true heading, NaN without a pose [rad].
        match_rate: the paper's match rate at the pose (2.3.3), NaN without one.
        runner_up_rate: the highest match rate of a wrong candidate, NaN where it was not asked for.
        chance_alignments: expected number of poses that match by chance as well as the truth does.
        milliseconds: time to the answer.
    """

    verdict: str
    reason: str
    position_error: float
    heading_error: float
    match_rate: float
    runner_up_rate: float
    chance_alignments: float
    milliseconds: float


class Task(NamedTuple):
    """One view to be scored, for another process."""

    matcher: str
    seed: int
    view: PaperView
    with_runners_up: bool


class Scorer:
    """Asks one matcher about views of one floor."""

    def __init__(self, matcher: str, seed: int) -> None:
        self._floor = paper_floor(seed)
        self._tree = KDTree(self._floor)
        self._addresses = build_address_matrix(self._floor, PoleStarSettings().address_block)
        self._locate = MATCHERS[matcher](self._floor)
        for view in paper_views(self._floor, spread_places(2), 0.5, 0.5, seed):
            self._locate(view.pixels)  # compiles

    @cached_property
    def _pole_star(self) -> PoleStarMatcher:
        return PoleStarMatcher(self._floor, PoleStarSettings())

    def score(self, view: PaperView, *, with_runners_up: bool) -> Score:
        """Return what the matcher's answer is worth; the pole-star pipeline names candidates where it does not."""
        answer, milliseconds = cpu_time(self._locate, view.pixels)
        points, found, truth = view_points(view.pixels), answer.T_map_view, view.T_map_view
        runner_up_rate = math.nan
        if with_runners_up:
            candidates = answer.candidates or self._pole_star.congruent_poses(points)
            rivals = [pose for pose in candidates if pose.T_map_view.distance_to(truth) > ELSEWHERE]
            runner_up_rate = max((pose.match_rate for pose in rivals), default=0.0)
        chance = self._chance_alignments(points, view.map_dots)
        verdict = verdict_of(found, truth)
        if found is None:
            nan = math.nan
            return Score(verdict, answer.reason, nan, nan, nan, runner_up_rate, chance, milliseconds)
        rate = match_rate(self._addresses, found.transform(points))
        distance, turn = found.distance_to(truth), abs(found.yaw_to(truth))
        return Score(verdict, '', distance, turn, rate, runner_up_rate, chance, milliseconds)

    def _chance_alignments(self, points: NDArray[np.float64], map_dots: NDArray[np.intp]) -> float:
        """Return how many poses by chance match as well as the best fit to the true dots."""
        true = map_dots >= 0
        if true.sum() < 2:
            return math.inf
        view = points @ np.array([1.0, 1.0j])
        on_map = self._floor[map_dots[true]] @ np.array([1.0, 1.0j])
        centred = view[true] - view[true].mean()
        scale_and_turn = np.vdot(centred, on_map) / np.vdot(centred, centred)
        aligned = scale_and_turn * (view - view[true].mean()) + on_map.mean()
        residuals, _ = self._tree.query(np.column_stack([aligned.real, aligned.imag]))
        log_chance = log_chance_alignments(
            residuals,
            0.5 * NOISE * MOUNT.xyz[2] / CAMERA.fx,
            float(pdist(points[true]).max()),
            float(len(self._floor)),
            len(self._floor) / math.prod(FLOOR_SIZE),
            LocalizerSettings().scale_tolerance,
        )
        return math.exp(min(log_chance, 700.0))


# It takes some seconds to build.
_scorer = cache(Scorer)


def score(task: Task) -> Score:
    """Score one view with this process's matcher."""
    return _scorer(task.matcher, task.seed).score(task.view, with_runners_up=task.with_runners_up)


def tasks(matcher: str, table: str, places: int, seed: int) -> Iterator[Task]:
    """Yield all views of a table in order."""
    floor = paper_floor(seed)
    for cell in TABLES[table]:
        chosen = spread_places(min(places, cell.places))
        for k, view in enumerate(paper_views(floor, chosen, cell.missing, cell.spurious, seed)):
            yield Task(matcher, seed, view, table == '4' and k % RUNNERS_UP_EVERY == 0)


def add_table(run: Run, table: str, by_cell: list[list[Score]]) -> None:
    """Add one of the tables 2, 3, 4 or the failed cases."""
    heads = ('right / none / wrong', 'the paper: right / wrong / none %', 'error mm: median / 95 % / max')
    found = run.table(
        'The failed cases' if table == 'failed' else f'Table {table}',
        *('missing %', 'spurious %', *heads, 'error °: the same', 'time ms: the same'),
    )
    for cell, scores in zip(TABLES[table], by_cell, strict=True):
        right = [score for score in scores if score.verdict == 'right']
        found.add(
            *(percent(cell.missing), percent(cell.spurious)),
            *(outcomes(score.verdict for score in scores), cell.paper),
            error([score.position_error for score in right], '.2f', 1e3),
            error([score.heading_error for score in right], '.2f', math.degrees(1.0)),
            time([score.milliseconds for score in scores], '.1f', (50, 95, 100)),
        )
    reasons = Counter(score.reason for scores in by_cell for score in scores if score.reason)
    if reasons:
        run.note(
            'No pose: ' + ', '.join(f'{number} x "{reason}"' for reason, number in reasons.most_common())
        )


def add_table_5(run: Run, by_cell: list[list[Score]]) -> None:
    """Add the match rates of right poses and of the best wrong candidates."""
    table = run.table(
        'Table 5', 'missing %', 'spurious %', 'lowest right %', 'highest wrong %', 'the paper %'
    )
    for cell, scores, paper in zip(TABLES['4'], by_cell, TABLE_5_PAPER, strict=True):
        lowest = min(
            (100 * score.match_rate for score in scores if score.verdict == 'right'), default=math.nan
        )
        highest = 100 * float(np.nanmax([score.runner_up_rate for score in scores]))
        table.add(
            *(percent(cell.missing), percent(cell.spurious)),
            *(count(lowest, '.1f', better='higher'), count(highest, '.1f'), paper),
        )


def add_chance(run: Run, scores: list[Score]) -> None:
    """Add in how many views the true pose exceeds chance alignments, and the outcomes."""
    table = run.table(
        '81 % missing, 9.5 % spurious', 'chance alignments at the truth', 'right / none / wrong'
    )
    for name, is_clear in ((f'fewer than {CHANCE_MAX:g}', True), ('more', False)):
        part = [score.verdict for score in scores if (score.chance_alignments < CHANCE_MAX) == is_clear]
        table.add(name, outcomes(part))


def main(run: Run, matcher: str, tables: tuple[str, ...], places: int) -> None:
    """Run the tables that are asked for."""
    for table in tables:
        scores = iter(in_processes(score, list(tasks(matcher, table, places, run.seed)), f'table {table}'))
        by_cell = [[next(scores) for _ in range(min(places, cell.places))] for cell in TABLES[table]]
        add_table(run, table, by_cell)
        if table == '4':
            add_table_5(run, by_cell)
        if table == 'failed':
            add_chance(run, by_cell[1])


if __name__ == '__main__':
    run_benchmark(
        main,
        matcher=Option('constellation', 'constellation', 'or pole_star'),
        tables=Option(tuple(TABLES), tuple(TABLES), '4 includes 5'),
        places=Option(1209, 20, 'most views of a cell'),
    )
