from collections import Counter

import numpy as np
import pytest
from dot_maps import random_map

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dots import DotMap
from floor_localizer.core.settings import LocalizerSettings
from floor_localizer.core.uniqueness import PlaceKind, ViewSettings, inspect_place, inspect_places, list_places
from shirube_core.geometry import SE2

VIEW, SETTINGS = ViewSettings(), LocalizerSettings()


def map_of(*points: np.ndarray) -> DotMap:
    joined = np.vstack(points)
    return DotMap(joined, np.full(len(joined), np.nan))


def inspected(dot_map: DotMap):
    floor = index_map(dot_map)
    return list(inspect_places(floor, list_places(floor.grid, VIEW), VIEW, SETTINGS))


def test_every_place_of_a_random_floor_is_unique_and_of_a_periodic_floor_ambiguous():
    assert {place.kind for place in inspected(random_map(1))} == {PlaceKind.UNIQUE}
    tile = random_map(2, (0.15, 0.15)).points
    tiles = [tile + 0.15 * np.array([i, j]) for i in range(3) for j in range(3)]
    assert {place.kind for place in inspected(map_of(*tiles))} == {PlaceKind.AMBIGUOUS}


@pytest.mark.parametrize('turn', [0.0, 0.5, np.pi])
def test_a_copied_part_is_found_and_its_original_named(turn):
    original = random_map(3).points
    T_copy = SE2(1.0, 0.2, turn)
    floor = index_map(map_of(original, T_copy.transform(original)))
    place = inspect_place(floor, (0.2, 0.15), VIEW, SETTINGS)
    assert place.kind is PlaceKind.AMBIGUOUS
    assert place.runner_up_fraction == 1.0
    assert place.runner_up is not None
    np.testing.assert_allclose(place.runner_up, T_copy.transform([(0.2, 0.15)])[0], atol=1e-4)


def test_a_copy_with_one_dot_in_ten_missing_is_found_and_one_with_half_of_them_is_not():
    original = random_map(4).points
    rng = np.random.default_rng(4)
    for fraction, kind in ((0.9, PlaceKind.AMBIGUOUS), (0.5, PlaceKind.UNIQUE)):
        copy = original[rng.random(len(original)) < fraction] + (1.0, 0.0)
        floor = index_map(map_of(original, copy))
        found = [inspect_place(floor, (x, 0.15), VIEW, SETTINGS).kind for x in (0.1, 0.2, 0.3)]
        assert Counter(found).most_common(1)[0][0] is kind


def test_a_mirrored_part_is_found():
    original = random_map(5).points
    floor = index_map(map_of(original, original * (-1.0, 1.0) + (1.5, 0.0)))
    place = inspect_place(floor, (0.2, 0.15), VIEW, SETTINGS)
    assert place.kind is PlaceKind.MIRROR_AMBIGUOUS
    assert place.runner_up is not None
    np.testing.assert_allclose(place.runner_up, (1.3, 0.15), atol=1e-4)


def test_a_corner_that_was_swept_bare_has_too_few_dots():
    dot_map = random_map(6)
    rng = np.random.default_rng(6)
    kept = (dot_map.points > (0.18, 0.15)).any(axis=1) | (rng.random(len(dot_map)) < 0.05)
    places = inspected(map_of(dot_map.points[kept]))
    thin = [place for place in places if place.kind is PlaceKind.TOO_FEW_DOTS]
    assert thin
    assert all(place.x < 0.18 and place.y < 0.15 for place in thin)
    assert all(place.expected_chance_alignments > SETTINGS.chance_alignments_max for place in thin)


def test_places_cover_the_floor_and_nothing_else():
    left = random_map(7).points
    floor = index_map(map_of(left, left + np.array([2.0, 1.0])))
    places = list_places(floor.grid, VIEW)
    assert 20 <= len(places) <= 40
    assert all(np.hypot(*(floor.grid.points - place).T).min() < 0.064 for place in places)
    few = list_places(floor.grid, ViewSettings(places_max=50))
    assert len(few) < len(places)
    # A map that is mostly gaps has places, too.
    rng = np.random.default_rng(0)
    points = np.vstack([rng.uniform(0.0, 0.2, (200, 2)), rng.uniform(3.0, 3.2, (200, 2))])
    floor = index_map(map_of(points))
    places = list_places(floor.grid, ViewSettings(places_max=1))
    assert len(places) == 1
    assert np.min(np.linalg.norm(points - places[0], axis=1)) < 1e-6
