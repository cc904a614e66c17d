"""Localization on a map of two floor levels: the level, and the pose in the level's frame."""

from dataclasses import replace

import numpy as np
import pytest
from floor_views import CAMERA, MOUNT, SIZE, is_right, pose_over, random_floor, see

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dots import DotMap, arrange_levels
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.fix import NoFixReason
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.tracker import FloorTracker
from shirube_core.geometry import SE2

NAMES = ('ground', 'first')
FLOORS = {name: random_floor(seed) for name, seed in zip(NAMES, (11, 12))}
NARROW = np.diag([1e-4, 1e-4, 1e-2])


def building(floors: dict[str, DotMap]) -> FloorLocalizer:
    levels = arrange_levels(list(floors), [(0.0, 0.0, *SIZE)] * len(floors))
    points = np.vstack([floor.points + level.offset for level, floor in zip(levels, floors.values())])
    indexed = index_map(DotMap(points, np.full(len(points), np.nan)))
    return FloorLocalizer(replace(indexed, levels=levels), MOUNT)


@pytest.fixture(scope='module')
def house() -> FloorLocalizer:
    return building(FLOORS)


def views(name: str, number: int):
    rng = np.random.default_rng(3)
    for _ in range(number):
        pose = pose_over(rng)
        yield pose, see(FLOORS[name], pose, rng, missing=0.25, spurious=12).dots


@pytest.mark.parametrize('name', NAMES)
def test_the_level_and_the_pose_on_it_are_found(house, name):
    for pose, dots in views(name, 8):
        fix = house.to_level(house.locate_dots(dots, CAMERA))
        assert is_right(fix, pose)
        assert fix.level == name
        from_points = fix.map_points[fix.matched]
        assert np.all((from_points > -0.01) & (from_points < np.array(SIZE) + 0.01))


def test_a_lift_changes_the_floor(house):
    tracker = FloorTracker(house)
    for k, name in enumerate([*NAMES, *NAMES]):
        pose, dots = next(views(name, 1))
        fix = tracker.track_dots(0.1 * k, dots, CAMERA)
        assert is_right(fix, pose)
        assert fix.level == name


def test_an_area_is_on_its_level(house):
    pose, dots = next(views('first', 1))
    tracker = FloorTracker(house)
    tracker.set_area(pose, NARROW, 'ground')
    assert tracker.track_dots(0.0, dots, CAMERA).reason is NoFixReason.OUTSIDE_AREA
    tracker.set_area(pose, NARROW, 'first')
    assert is_right(tracker.track_dots(0.1, dots, CAMERA), pose)


def test_floors_that_look_the_same_are_ambiguous():
    ambiguous = building({'left': FLOORS['ground'], 'right': FLOORS['ground']})
    _, dots = next(views('ground', 1))
    assert ambiguous.locate_dots(dots, CAMERA).reason is NoFixReason.AMBIGUOUS


def test_a_missing_level_is_named_with_the_existing_ones(house, localizer):
    pose = SE2(0.3, 0.2, 0.1)
    for place, name, named in ((house, 'roof', 'ground, first'), (house, '', 'ground'), (localizer, 'ground', 'none')):
        with pytest.raises(FloorLocalizerError, match=f"no level '{name}'; it has: {named}"):
            place.to_map(pose, name)
    with pytest.raises(FloorLocalizerError, match="no level ''"):
        FloorTracker(house).set_area(pose, NARROW)
    assert localizer.to_map(pose, '') == pose
