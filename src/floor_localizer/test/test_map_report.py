import numpy as np
import pytest
from dot_maps import DENSITY, random_map

from floor_localizer.commands.map_report import map_report
from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dots import DotMap


def report(dot_map: DotMap) -> dict[str, str]:
    lines = map_report(dot_map, index_map(dot_map)).splitlines()
    return {line[:16].strip(): line[16:] for line in lines}


def number(text: str, place: int = 0) -> float:
    return float(text.replace('%', '').split()[place])


def test_statistics_are_those_of_the_generated_floor():
    dot_map = random_map(1)
    found = report(dot_map)
    assert found['dots'] == str(len(dot_map))
    assert [number(found['extent'], k) for k in (0, 2)] == pytest.approx([0.4, 0.3], abs=0.01)
    area = len(dot_map) / number(found['density'])
    assert area == pytest.approx(0.12, rel=0.1)
    assert number(found['area with dots']) == pytest.approx(area, abs=0.001)
    assert number(found['density']) == pytest.approx(DENSITY, rel=0.1)
    assert [number(found['diameters'], k) for k in (0, 2, 5)] == pytest.approx([2.0, 3.0, 2.5], abs=0.1)


def test_a_gap_between_two_rooms_is_no_area():
    room = random_map(2)
    both = DotMap(np.vstack([room.points, room.points + np.array([5.0, 3.0])]), np.tile(room.diameters, 2))
    assert number(report(both)['area with dots']) == pytest.approx(0.24, rel=0.2)


def test_unknown_diameters_are_left_out_and_counted():
    dot_map = random_map(3)
    dot_map.diameters[::4] = np.nan
    assert report(dot_map)['diameters'].endswith('known for 75% of the dots')
    assert report(DotMap(dot_map.points, np.full(len(dot_map), np.nan)))['diameters'] == 'unknown'
