"""Time to a fix without a prior compared with other methods, on the paper's conditions and the same views, in one run.

The methods take turns after every twenty views, so that each finds the processor's caches as it left them most of the
time. Times are processor time on one core, from centroids to the pose.

- shirube: dot sizes not used; 5 % of scale and 2 degrees of tilt are searched.
- tetra3rs, a star solver: the right scale and no tilt given; with sizes that are exactly those of the map, its best
  case, and with uninformative sizes.
- pole star: the paper's method written out plainly (`core/pole_star`), right scale and no tilt given.
- SIFT: FLANN and a vote on pictures of a patch of an eighth of the area; extraction is not counted.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from _harness import Option, Run, progress, run_benchmark, use_one_core
from _paper_matchers import constellation, indexed, pole_star
from _paper_views import CONDITIONS, PaperView, paper_floor, paper_views, spread_places
from _peer_sift import SiftMatcher, patch_floor, pictures
from _peer_tetra3rs import StarSolver
from _pose_scores import PoseScore, time_answer, time_cells
from numpy.typing import NDArray

from floor_localizer.localization.localizer_from_map_file import compile_kernels
from shirube_core.geometry import SE2

OURS = 'shirube'
TURN = 20


class Method(NamedTuple):
    """One method: what makes of a view what it takes (not timed), what finds the pose, and whether it is slow."""

    prepare: Callable[[PaperView], NDArray[np.float64]]
    locate: Callable[[NDArray[np.float64]], SE2 | None]
    is_slow: bool = False


def methods(run: Run, floor: NDArray[np.float64]) -> dict[str, Method]:
    """Return the methods that take dots, ready for a floor, shape (N, 2) [m]."""
    ours, paper = constellation(indexed(floor)), pole_star(floor)
    found = {OURS: Method(lambda view: view.pixels, lambda pixels: ours(pixels).T_map_view)}
    tetra3rs = run.peer('tetra3rs', 'tetra3rs==0.14')
    if tetra3rs is not None:
        solver = StarSolver(tetra3rs, floor, run.seed)
        run.note(f'Database of tetra3rs: {solver.database_bytes / 1e6:.0f} MB')
        for name, with_sizes in (('tetra3rs, sizes of the map', True), ('tetra3rs, no sizes', False)):
            found[name] = Method(partial(solver.centroids, with_sizes=with_sizes), solver.locate, not with_sizes)
    found['pole star (the paper)'] = Method(lambda view: view.pixels, lambda p: paper(p).T_map_view, True)
    return found


def time_all(compared: dict[str, Method], views: list[PaperView], slow_places: int) -> dict[str, list[PoseScore]]:
    """Ask all methods about the views by turns; slow ones about some, spread over all."""
    asked = set(np.linspace(0, len(views) - 1, min(slow_places, len(views))).round().astype(int).tolist())
    answers: dict[str, list[PoseScore]] = {name: [] for name in compared}
    for begin in progress(range(0, len(views), TURN)):
        for name, method in compared.items():
            for number in range(begin, min(begin + TURN, len(views))):
                if not method.is_slow or number in asked:
                    prepared = method.prepare(views[number])
                    answers[name].append(time_answer(method.locate, prepared, views[number].T_map_view))
    return answers


def main(run: Run, places: int, slow_places: int) -> None:
    """Compare the methods."""
    use_one_core()
    compile_kernels()
    floor = paper_floor(run.seed)
    compared, sift, patch = methods(run, floor), SiftMatcher(patch_floor(1)), patch_floor(1)
    for name, (missing, spurious) in CONDITIONS.items():
        views = list(paper_views(floor, spread_places(places), missing, spurious, run.seed))
        answers = time_all(compared, views, slow_places)
        answers['SIFT on a patch of 1.8 x 1.2 m'] = [
            time_answer(sift.locate, sift.features(image), pose)
            for image, pose in progress(pictures(patch, slow_places, missing, spurious, 1), 'SIFT', slow_places)
        ]
        heads = 'method | views | time ms: median / 95 % | median in units of ours | right / none / wrong'
        table = run.table(name, heads)
        for method, given in answers.items():
            table.add(method, len(given), *time_cells(given, answers[OURS], '.3g', 'higher'))


if __name__ == '__main__':
    run_benchmark(
        main,
        places=Option(400, 30, 'views of each condition'),
        slow_places=Option(40, 2, 'of these for the slow methods'),
    )
