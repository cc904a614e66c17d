"""Random corridors: seeds repeat and differ, the meters are identical, no landmarks overlap."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from scene_simulator.corridor.generator import CorridorDesign, corridor
from scene_simulator.corridor.instruments import Meter
from scene_simulator.corridor.scene import CorridorScene, Person
from scene_simulator.errors import SceneError


def meters(scene: CorridorScene) -> list[Meter]:
    return [item for item in scene.objects if isinstance(item, Meter)]


def test_the_same_seed_gives_the_same_corridor_and_another_one_another() -> None:
    first, again, other = (corridor(CorridorDesign(seed)) for seed in (5, 5, 6))
    assert first == again
    np.testing.assert_array_equal(first.table.points, again.table.points)
    assert not np.array_equal(first.table.points, other.table.points)


@pytest.mark.parametrize('seed', range(12))
def test_five_equal_meters_stand_in_a_row(seed: int) -> None:
    row = meters(corridor(CorridorDesign(seed)))
    assert [meter.name for meter in row] == [f'meter_{i}' for i in range(5)]
    assert len({(meter.radius, meter.position[1], meter.surface) for meter in row}) == 1
    gaps = np.diff([meter.position[0] for meter in row])
    assert (gaps > 2.2 * row[0].radius).all()
    assert gaps.std() > 0.001
    even = np.diff([meter.position[0] for meter in meters(corridor(CorridorDesign(seed, even=True)))])
    assert even.std() == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize('seed', range(30))
def test_nothing_on_the_end_wall_overlaps(seed: int) -> None:
    scene = corridor(CorridorDesign(seed))
    parts = [x for x in scene.landmarks if x.surface.right == (0.0, -1.0, 0.0) and '/' not in x.name]
    assert len(parts) == 13
    for first, second in itertools.combinations(parts, 2):
        (left, bottom), (right, top) = first.extent
        (other_left, other_bottom), (other_right, other_top) = second.extent
        apart = right < other_left or other_right < left or top < other_bottom or other_top < bottom
        assert apart, (first.name, second.name)


def test_needles_change_nothing_but_the_readings() -> None:
    first, second = (corridor(CorridorDesign(7, needles=needles)) for needles in (0, 1))
    assert all(a.reading != b.reading for a, b in zip(meters(first), meters(second), strict=True))
    objects = zip(first.objects, second.objects, strict=True)
    assert all((replace(a, reading=b.reading) if isinstance(a, Meter) else a) == b for a, b in objects)


def test_a_bare_wall_has_only_meters() -> None:
    scene = corridor(CorridorDesign(2, bare=True))
    wall = [x.name for x in scene.landmarks if x.surface.right == (0.0, -1.0, 0.0)]
    assert wall == [f'meter_{i}' for i in range(5)]


def test_tiles_add_joints_and_change_nothing_else() -> None:
    plain, tiled = corridor(CorridorDesign(2)), corridor(CorridorDesign(2, tile=0.2))
    assert plain.objects[1:] == tiled.objects[1:]
    assert len(tiled.table.starts) > len(plain.table.starts) + 100


def test_people_occlude_everything_the_nearest_last() -> None:
    scene = corridor(CorridorDesign(3, people=4))
    figures = scene.objects[-4:]
    assert all(isinstance(item, Person) for item in figures)
    distances = [item.surface.origin[0] for item in figures]
    assert distances == sorted(distances, reverse=True)
    assert distances[0] < 0.0
    assert len(scene.table.starts) == len(corridor(CorridorDesign(3)).table.starts) + 4 * 16


def test_a_design_that_cannot_be_is_refused() -> None:
    for bad in ({'seed': -1}, {'people': -1}, {'needles': -2}, {'tile': -0.1}, {'tile': 0.001}):
        with pytest.raises(SceneError):
            CorridorDesign(**bad)
