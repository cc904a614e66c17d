"""What limits views of few dots (figures 28 to 31): the expected number of chance alignments at the true pose.

No search and no decision can find a view reliably if chance explains it as well. Each view of table 1 is scored at
its true pose, as by a perfect search: on the whole floor, with a camera whose height is known to 1 % (as the
paper's), and with a rough area of 0.3 m and 0.5 rad around the pose. A pose is accepted below 10^-3.
"""

import cmath
import math
from dataclasses import replace

import numpy as np
from _figures import measured, rate
from _harness import Option, Run, progress, run_benchmark
from _paper_matchers import indexed, view_dots
from _paper_views import paper_floor, paper_views, spread_places
from paper_tables import TABLES

from floor_localizer.core.constellation.acceptance import new_search, score_hypothesis
from floor_localizer.core.settings import LocalizerSettings

SETTINGS = LocalizerSettings()
KNOWN_HEIGHT = replace(SETTINGS, scale_tolerance=0.01)
AREA_RADIUS, AREA_YAW = 0.3, 0.5


def main(run: Run, places: int) -> None:
    """Score the views of table 1 at their true poses."""
    points = paper_floor(run.seed)
    floor, chosen = indexed(points), spread_places(places)
    whole = float(len(points))
    near = floor.density * math.pi * AREA_RADIUS**2 * AREA_YAW / math.pi
    conditions = (SETTINGS, whole), (KNOWN_HEIGHT, whole), (SETTINGS, near)
    heads = 'the paper | noise px | chance alignments, median'
    table = run.table('Significance at the true pose', heads, 'significant % | known height | rough area')
    for cell in progress(TABLES['1']):
        logs = []
        for view in paper_views(points, chosen, 0.0, 0.0, run.seed, cell.noise, cell.dots):
            pose, row = view.T_map_view, []
            for settings, candidates in conditions:
                seen = view_dots(view.pixels, floor.density, cell.noise, settings)
                search = new_search(len(seen.z), candidates, SETTINGS.chance_alignments_max, SETTINGS.match_rate_min)
                score_hypothesis(floor.grid, seen, search, cmath.exp(1j * pose.yaw), complex(pose.x, pose.y))
                row.append(search.best.log_chance)
            logs.append(row)
        significant = np.sum(np.array(logs) < math.log(SETTINGS.chance_alignments_max), axis=0)
        table.add(
            cell.paper,
            f'{cell.noise:g}',
            measured(float(np.exp(np.median(np.array(logs)[:, 0]))), '.1e'),
            *(rate(int(number), len(logs), form='percent') for number in significant),
        )


if __name__ == '__main__':
    run_benchmark(main, places=Option(1209, 20, 'most views of a cell'))
