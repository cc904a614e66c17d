import numpy as np
from dot_maps import DENSITY, random_map

from floor_localizer.commands.map_report import compute_map_statistics
from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dots import DotMap


def test_statistics_are_those_of_the_generated_floor() -> None:
    dot_map = random_map(1)
    statistics = compute_map_statistics(dot_map, index_map(dot_map))
    assert statistics.dots == len(dot_map)
    np.testing.assert_allclose(statistics.upper - statistics.lower, (0.4, 0.3), atol=0.01)
    assert abs(statistics.area / 0.12 - 1.0) < 0.1
    assert abs(statistics.density / DENSITY - 1.0) < 0.1
    assert statistics.diameters is not None
    np.testing.assert_allclose(statistics.diameters, (0.002, 0.0025, 0.003), atol=1e-4)


def test_a_gap_between_two_rooms_is_no_area() -> None:
    room = random_map(2)
    both = DotMap(np.vstack([room.points, room.points + np.array([5.0, 3.0])]), np.tile(room.diameters, 2))
    assert abs(compute_map_statistics(both, index_map(both)).area / 0.24 - 1.0) < 0.2


def test_unknown_diameters_are_left_out_and_counted() -> None:
    dot_map = random_map(3)
    dot_map.diameters[::4] = np.nan
    assert abs(compute_map_statistics(dot_map, index_map(dot_map)).known_diameter_fraction - 0.75) < 0.01
    unknown = DotMap(dot_map.points, np.full(len(dot_map), np.nan))
    assert compute_map_statistics(unknown, index_map(unknown)).diameters is None
