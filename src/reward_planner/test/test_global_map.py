"""The global map keeps known cells, accepts new ones, and grows only with the observed area."""

import numpy as np
import pytest

from reward_planner.core.mapping.global_map import GlobalMap, LocalMap
from reward_planner.core.occupancy_map import FREE, OCCUPIED, UNKNOWN, GridFrame
from reward_planner.core.reward_planner_error import RewardPlannerError


def patch(row, column, cells, observed=None, resolution=0.05):
    """A local map whose first cell is a cell of the map."""
    cells = np.array(cells, dtype=np.int8)
    frame = GridFrame(column * resolution, row * resolution, resolution, cells.shape[1], cells.shape[0])
    return LocalMap(frame, cells, cells != UNKNOWN if observed is None else observed)


def value(area, row, column):
    """The value of a cell of the map."""
    return area.occupancy_in(GridFrame(0.05 * column, 0.05 * row, 0.05, 1, 1))[0, 0]


def test_what_is_written_can_be_read_anywhere():
    area, rng = GlobalMap(0.05, 10_000_000), np.random.default_rng(0)
    book = {}
    for _ in range(60):
        row, column = rng.integers(-400, 400, 2).tolist()
        cells = rng.choice([UNKNOWN, FREE, OCCUPIED], (50, 90))
        observed = rng.random(cells.shape) < 0.3
        area.write(patch(row, column, cells, observed))
        book |= {(row + i, column + j): cells[i, j] for i, j in np.argwhere(observed).tolist()}
    frame, cells = area.occupancy()
    first = np.round(np.array([frame.origin_y, frame.origin_x]) / frame.resolution).astype(int)
    expected = np.full(cells.shape, UNKNOWN)
    for (row, column), known in book.items():
        expected[row - first[0], column - first[1]] = known
    assert (cells == expected).all()


def test_cells_without_evidence_keep_what_was_known_and_those_that_rays_took_back_are_unknown():
    area = GlobalMap(0.05, 1_000_000)
    area.write(patch(0, 0, [[OCCUPIED, FREE]]))
    area.write(patch(0, 0, [[UNKNOWN, OCCUPIED]]))
    assert (value(area, 0, 0), value(area, 0, 1)) == (OCCUPIED, OCCUPIED)
    area.write(patch(0, 0, [[UNKNOWN]], observed=np.array([[True]])))
    assert value(area, 0, 0) == UNKNOWN


def test_memory_grows_with_the_ground_in_any_direction():
    sizes = []
    for step in ((0, 40), (40, 40)):
        area = GlobalMap(0.05, 2_000_000_000)
        for k in range(500):
            area.write(patch(k * step[0], k * step[1], np.zeros((80, 80))))
        sizes.append(area.bytes)
    assert max(sizes) < 500 * 40 * 80 * 8


def test_cells_beyond_the_budget_are_refused_and_reported():
    area = GlobalMap(0.05, 20_000)
    for k in range(10):
        area.write(patch(0, 64 * k, np.zeros((10, 10))))
    assert area.bytes <= 20_000
    assert area.rejected_cells == 600
    assert value(area, 5, 69) == FREE


def test_a_map_too_large_to_be_given_out_whole_is_given_in_parts():
    area = GlobalMap(0.05, 1_000_000)
    area.write(patch(0, 0, [[OCCUPIED]]))
    area.write(patch(100_000, 100_000, [[OCCUPIED]]))
    assert area.rejected_cells == 0
    with pytest.raises(RewardPlannerError, match='use a part'):
        area.occupancy()
    cells = area.occupancy_in(GridFrame(4999.95, 4999.9, 0.05, 5, 4))
    assert np.argwhere(cells == OCCUPIED).tolist() == [[2, 1]]
    assert (cells == OCCUPIED).sum() + (cells == UNKNOWN).sum() == 20


def test_a_map_in_which_nothing_is_known_has_no_frame():
    area = GlobalMap(0.05, 100_000)
    area.write(patch(0, 0, [[UNKNOWN]]))
    assert area.frame() is None
    assert area.occupancy() is None
    area.write(patch(0, 0, [[FREE]]))
    area.clear()
    assert area.frame() is None


def test_a_known_map_that_is_out_of_step_goes_to_the_nearest_cells():
    area = GlobalMap(0.05, 100_000)
    frame = GridFrame(-10.02, 3.01, 0.05, 2, 1)
    area.write(LocalMap(frame, np.array([[OCCUPIED, FREE]], dtype=np.int8), np.ones((1, 2), dtype=np.bool_)))
    assert (value(area, 60, -200), value(area, 60, -199)) == (OCCUPIED, FREE)


def test_maps_that_do_not_fit_are_refused():
    area = GlobalMap(0.05, 100_000)
    with pytest.raises(RewardPlannerError, match='same resolution'):
        area.write(patch(0, 0, [[FREE]], resolution=0.1))
    frame = GridFrame(0.0, 0.0, 0.05, 3, 2)
    with pytest.raises(RewardPlannerError, match='shape'):
        area.write(LocalMap(frame, np.zeros((3, 2), dtype=np.int8), np.ones((3, 2), dtype=np.bool_)))
