"""Time to a fix without a prior compared with other methods, on the paper's conditions and the same views, in one run.

    shirube bench time_to_fix
    shirube bench time_to_fix --places 100 --slow-places 10

The methods take turns after every twenty views, so that each finds the processor's caches as it left them most of the
time. Times are processor time on one core, from centroids to the pose.

- shirube: dot sizes not used; 5 % of scale and 2 degrees of tilt are searched.
- tetra3rs, a star solver: the right scale and no tilt given; with sizes that are exactly those of the map, its best
  case, and with uninformative sizes.
- pole star: the paper's method written out plainly (`core/pole_star`), right scale and no tilt given.
- SIFT: FLANN and a vote on pictures of a patch of an eighth of the area; extraction is not counted.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from _paper_matchers import constellation, pole_star
from _paper_views import PaperView, paper_floor, paper_places, paper_views
from _peer_sift import SiftMatcher, patch_floor, pictures
from _peer_tetra3rs import INSTALL, IS_INSTALLED, StarSolver
from _timed_answers import TimedAnswer, outcome_rates, time_answer, time_quantiles, use_one_core
from numpy.typing import NDArray
from tqdm import tqdm

from floor_localizer.core.compile_kernels import compile_kernels
from shirube_core.geometry import SE2

CONDITIONS = ((0.25, 0.3), (0.25, 0.5))
OURS = 'shirube'
TURN = 20


class Method(NamedTuple):
    """One method.

    Attributes:
        name: name in the table.
        prepare: makes of a view what the method takes; not timed.
        locate: finds the pose.
        is_slow: asked about few views.
    """

    name: str
    prepare: Callable[[PaperView], NDArray[np.float64]]
    locate: Callable[[NDArray[np.float64]], SE2 | None]
    is_slow: bool = False


def methods(floor: NDArray[np.float64], seed: int) -> list[Method]:
    """Return the methods that take dots, ready for a floor, shape (N, 2) [m]."""
    ours, paper = constellation(floor), pole_star(floor)
    found = [Method(OURS, lambda view: view.pixels, lambda pixels: ours(pixels).T_map_view)]
    if not IS_INSTALLED:
        print(INSTALL)
    else:
        solver = StarSolver(floor, seed)
        print(f'Database of tetra3rs: {solver.database_bytes / 1e6:.0f} MB')
        for name, with_sizes in (('tetra3rs, sizes of the map', True), ('tetra3rs, no sizes', False)):
            found.append(Method(name, _centroids_of(solver, with_sizes), solver.locate, not with_sizes))
    found.append(
        Method('pole star (the paper)', lambda view: view.pixels, lambda p: paper(p).T_map_view, True)
    )
    return found


def _centroids_of(solver: StarSolver, with_sizes: bool) -> Callable[[PaperView], NDArray[np.float64]]:
    return lambda view: solver.centroids(view, with_sizes=with_sizes)


def time_all(
    compared: list[Method], views: list[PaperView], slow_places: int
) -> dict[str, list[TimedAnswer]]:
    """Ask all methods about the views by turns; slow ones about some, spread over all."""
    asked = set(np.linspace(0, len(views) - 1, min(slow_places, len(views))).round().astype(int).tolist())
    answers: dict[str, list[TimedAnswer]] = {method.name: [] for method in compared}
    turns = range(0, len(views), TURN)
    for begin, method in tqdm([(begin, method) for begin in turns for method in compared], leave=False):
        for number in range(begin, min(begin + TURN, len(views))):
            if not method.is_slow or number in asked:
                prepared = method.prepare(views[number])
                answers[method.name].append(time_answer(method.locate, prepared, views[number].T_map_view))
    return answers


def sift_answers(matcher: SiftMatcher, missing: float, spurious: float, number: int) -> list[TimedAnswer]:
    """Ask SIFT about pictures of its patch."""
    views = tqdm(pictures(patch_floor(1), number, missing, spurious, 1), total=number, leave=False)
    return [time_answer(matcher.locate, matcher.features(view.image), view.T_map_view) for view in views]


def print_times(answers: dict[str, list[TimedAnswer]]) -> None:
    """Print one condition."""
    print(
        '| method | views | time ms: median / 95 % | in units of ours: median / 95 % | right / none / wrong |'
    )
    print('|---|---|---|---|---|')
    ours = time_quantiles(answers[OURS])
    for name, given in answers.items():
        median, high = time_quantiles(given)
        print(
            f'| {name} | {len(given)} | {median:.3g} / {high:.3g} '
            f'| {median / ours[0]:.3g} / {high / ours[1]:.3g} | {outcome_rates(given)} |'
        )


def main() -> int:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--places', type=int, default=400, help='views of each condition')
    parser.add_argument('--slow-places', type=int, default=40, help='of these for the slow methods')
    parser.add_argument('--seed', type=int, default=1)
    arguments = parser.parse_args()
    use_one_core()
    compile_kernels()
    floor, places = paper_floor(arguments.seed), paper_places()
    places = places[np.linspace(0, len(places) - 1, min(arguments.places, len(places))).round().astype(int)]
    compared = methods(floor, arguments.seed)
    sift = SiftMatcher(patch_floor(1))
    for missing, spurious in CONDITIONS:
        views = list(paper_views(floor, places, missing, spurious, arguments.seed))
        answers = time_all(compared, views, arguments.slow_places)
        answers['SIFT on a patch of 1.8 x 1.2 m'] = sift_answers(
            sift, missing, spurious, arguments.slow_places
        )
        print(f'\n{100 * missing:.0f} % missing, {100 * spurious:.0f} % spurious:\n')
        print_times(answers)
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
