"""Invariances of a key, and its reconstruction from cell and subcell."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from floor_localizer.core.constellation.constellation_key import (
    LANE_HASHES,
    LANES,
    LOWER,
    OTHERS,
    PARTS,
    base_coordinates,
    bucket_of_hash,
    cell_step,
    cut_into_steps,
    from_steps,
    hash_of_steps,
    imbalance,
    pack_parts,
    part_of_lane,
    sort_by_x,
    to_steps,
    turn_around,
)

# The first call compiles.
UNHURRIED = settings(deadline=None)
STEP = 0.013
STEPS = hnp.arrays(np.int64, LANES, elements=st.integers(0, 160))
IN_LENS = np.array([[0.2, 0.5], [0.45, -0.3], [0.6, 0.1], [0.85, -0.4]])


def coordinates(points, first=0, second=1):
    xy = np.empty((OTHERS, 2))
    base_coordinates(points, first, second, np.arange(2, 6), xy)
    return xy


def six_dots(rng):
    return np.vstack([[[0.0, 0.0], [1.0, 0.0]], rng.uniform((0.1, -0.5), (0.9, 0.5), (OTHERS, 2))])


def test_base_lies_on_zero_and_one():
    points = np.random.default_rng(0).normal(size=(6, 2))
    xy = np.empty((OTHERS, 2))
    base_coordinates(points, 0, 1, np.array([0, 1, 0, 1]), xy)
    np.testing.assert_allclose(xy, [[0, 0], [1, 0], [0, 0], [1, 0]], atol=1e-12)


def test_coordinates_are_left_alone_in_the_base_itself():
    points = six_dots(np.random.default_rng(1))
    np.testing.assert_allclose(coordinates(points), points[2:], atol=1e-12)


@pytest.mark.parametrize('seed', range(5))
def test_shift_turn_and_scale_change_nothing(seed):
    rng = np.random.default_rng(seed)
    points = six_dots(rng)
    angle, scale = rng.uniform(-math.pi, math.pi), rng.uniform(0.01, 50.0)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    moved = scale * points @ turn.T + rng.normal(0.0, 5.0, 2)
    np.testing.assert_allclose(coordinates(moved), coordinates(points), atol=1e-10)


def test_a_mirror_changes_the_sign_of_y():
    points = six_dots(np.random.default_rng(2))
    np.testing.assert_allclose(
        coordinates(points * (1.0, -1.0)), coordinates(points) * (1.0, -1.0), atol=1e-12
    )


def test_turning_around_twice_is_nothing():
    xy = IN_LENS.copy()
    turn_around(xy)
    turn_around(xy)
    np.testing.assert_allclose(xy, IN_LENS, atol=1e-15)


def test_turning_around_is_exchanging_the_ends():
    points = six_dots(np.random.default_rng(3))
    xy = coordinates(points)
    turn_around(xy)
    np.testing.assert_allclose(xy, coordinates(points, first=1, second=0), atol=1e-12)


def test_imbalance_changes_its_sign_with_the_ends():
    xy = IN_LENS.copy()
    before = imbalance(xy)
    turn_around(xy)
    assert before == pytest.approx(np.mean(IN_LENS[:, 0]) - 0.5)
    assert imbalance(xy) == pytest.approx(-before)


def test_sorting_keeps_the_dots_whole():
    xy = IN_LENS[[2, 0, 3, 1]].copy()
    sort_by_x(xy)
    np.testing.assert_array_equal(xy, IN_LENS)


def steps_of(xy, step=STEP):
    steps = np.empty(LANES, dtype=np.int64)
    cut_into_steps(xy, step, steps)
    return steps


def hash_of(steps):
    return int(hash_of_steps(steps))


def test_key_does_not_depend_on_the_order_of_the_dots_once_sorted():
    keys = set()
    for order in ([0, 1, 2, 3], [3, 2, 1, 0], [1, 3, 0, 2]):
        xy = IN_LENS[order].copy()
        sort_by_x(xy)
        keys.add(tuple(steps_of(xy)))
    assert len(keys) == 1


def test_steps_hold_the_coordinates_to_half_a_step():
    steps = steps_of(IN_LENS).reshape(OTHERS, 2)
    middles = [[from_steps(steps[k, axis], LOWER[axis], STEP) for axis in range(2)] for k in range(OTHERS)]
    assert np.max(np.abs(middles - IN_LENS)) <= 0.5001 * STEP


def test_coordinates_below_the_range_are_in_its_first_step():
    assert to_steps(-5.0, LOWER[0], STEP) == 0


@UNHURRIED
@given(STEPS)
def test_parts_tell_the_place_in_the_cell_along_every_lane(steps):
    parts = np.uint64(pack_parts(steps))
    assert parts < 1 << 24
    assert [part_of_lane(parts, lane) for lane in range(LANES)] == (steps % PARTS).tolist()


@UNHURRIED
@given(STEPS, STEPS)
def test_keys_of_the_same_cell_have_the_same_hash_and_others_another(steps, others):
    same = bool(np.all(steps // PARTS == others // PARTS))
    assert (hash_of(steps) == hash_of(others)) == same


@UNHURRIED
@given(STEPS, st.integers(0, LANES - 1))
def test_the_next_cell_along_a_lane_is_an_addition_away(steps, lane):
    beyond = steps + PARTS * (np.arange(LANES) == lane)
    assert hash_of(beyond) == (hash_of(steps) + int(LANE_HASHES[lane])) % 2**64


@pytest.mark.parametrize('number', [1, 3, 4096, 5000, 10**8])
def test_buckets_are_within_their_number(number):
    assert bucket_of_hash(np.uint64(0), number) == 0
    assert bucket_of_hash(np.uint64(2**64 - 1), number) == number - 1


def test_keys_of_a_random_floor_are_spread_over_the_buckets():
    cells = np.random.default_rng(0).integers(0, 8, (4000, LANES))
    buckets = [bucket_of_hash(np.uint64(hash_of(PARTS * row)), 4100) for row in cells]
    fullest = np.bincount(buckets, minlength=4100).max()
    assert len(np.unique(buckets)) > 0.55 * 4100
    assert fullest < 12


def test_cells_of_a_hundred_times_more_keys_are_finer_by_the_eighth_root():
    assert cell_step(10**8, 0.5) / cell_step(10**6, 0.5) == pytest.approx(100.0 ** (-1.0 / LANES))
    assert cell_step(8 * 10**6, 4.0) == pytest.approx(cell_step(10**6, 0.5))
    assert cell_step(0, 0.5) > 0
    assert cell_step(10**14, 0.5) > 0
