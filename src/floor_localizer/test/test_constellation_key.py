"""Invariances of a key, and its reconstruction from cell and subcell."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from six_dots import coordinates, six_dots, steps_of

from floor_localizer.core.constellation.constellation_key import (
    COORDINATE_HASHES,
    INNER_DOTS,
    KEY_SIZE,
    LOWER,
    STEPS_PER_CELL,
    bucket_of_hash,
    cell_step,
    dequantize,
    hash_cell,
    mean_x_offset,
    pack_subcell,
    quantize,
    sort_by_x,
    subcell_step,
    swap_ends,
)

# The first call compiles.
UNHURRIED = settings(deadline=None)
STEP = 0.013
STEPS = hnp.arrays(np.int64, KEY_SIZE, elements=st.integers(0, 160))
IN_LENS = np.array([[0.2, 0.5], [0.45, -0.3], [0.6, 0.1], [0.85, -0.4]])


def test_baseline_is_mapped_to_zero_and_one_and_in_its_own_frame_nothing_changes():
    points = np.random.default_rng(0).normal(size=(6, 2))
    xy = coordinates(points, 0, 1, 0, 1, 0, 1)
    np.testing.assert_allclose(xy, [[0, 0], [1, 0], [0, 0], [1, 0]], atol=1e-12)
    points = six_dots(np.random.default_rng(1))
    np.testing.assert_allclose(coordinates(points), points[2:], atol=1e-12)


@pytest.mark.parametrize('seed', range(5))
def test_shift_turn_and_scale_change_nothing_and_a_mirror_the_sign_of_y(seed):
    rng = np.random.default_rng(seed)
    points = six_dots(rng)
    angle, scale = rng.uniform(-math.pi, math.pi), rng.uniform(0.01, 50.0)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    moved = scale * points @ turn.T + rng.normal(0.0, 5.0, 2)
    np.testing.assert_allclose(coordinates(moved), coordinates(points), atol=1e-10)
    mirrored = coordinates(points * (1.0, -1.0))
    np.testing.assert_allclose(mirrored, coordinates(points) * (1.0, -1.0), atol=1e-12)


def test_swapping_the_ends_equals_swapping_the_dots_and_twice_is_the_identity():
    points = six_dots(np.random.default_rng(3))
    xy = coordinates(points)
    before = mean_x_offset(xy)
    swap_ends(xy)
    np.testing.assert_allclose(xy, coordinates(points, 1, 0), atol=1e-12)
    assert before == pytest.approx(np.mean(points[2:, 0]) - 0.5)
    assert mean_x_offset(xy) == pytest.approx(-before)
    swap_ends(xy)
    np.testing.assert_allclose(xy, coordinates(points), atol=1e-15)


def hash_of(steps):
    return int(hash_cell(steps))


def test_sorting_keeps_the_dots_whole_so_that_their_order_does_not_matter():
    for order in ([0, 1, 2, 3], [3, 2, 1, 0], [1, 3, 0, 2]):
        xy = IN_LENS[order].copy()
        sort_by_x(xy)
        np.testing.assert_array_equal(xy, IN_LENS)


def test_steps_hold_the_coordinates_to_half_a_step_and_those_below_the_range_are_in_the_first():
    steps = steps_of(IN_LENS, STEP).reshape(INNER_DOTS, 2)
    middles = [[dequantize(row[axis], LOWER[axis], STEP) for axis in range(2)] for row in steps]
    assert np.max(np.abs(middles - IN_LENS)) <= 0.5001 * STEP
    assert quantize(-5.0, LOWER[0], STEP) == 0


@UNHURRIED
@given(STEPS)
def test_subcell_holds_the_step_of_every_coordinate(steps):
    subcell = np.uint64(pack_subcell(steps))
    assert subcell < 1 << 24
    assert [subcell_step(subcell, k) for k in range(KEY_SIZE)] == (steps % STEPS_PER_CELL).tolist()


@UNHURRIED
@given(STEPS, STEPS)
def test_keys_of_the_same_cell_have_the_same_hash_and_others_another(steps, others):
    same = bool(np.all(steps // STEPS_PER_CELL == others // STEPS_PER_CELL))
    assert (hash_of(steps) == hash_of(others)) == same


@UNHURRIED
@given(STEPS, st.integers(0, KEY_SIZE - 1))
def test_the_next_cell_along_a_coordinate_is_an_addition_away(steps, coordinate):
    beyond = steps + STEPS_PER_CELL * (np.arange(KEY_SIZE) == coordinate)
    assert hash_of(beyond) == (hash_of(steps) + int(COORDINATE_HASHES[coordinate])) % 2**64


@pytest.mark.parametrize('number', [1, 3, 4096, 5000, 10**8])
def test_buckets_are_within_their_number(number):
    assert bucket_of_hash(np.uint64(0), number) == 0
    assert bucket_of_hash(np.uint64(2**64 - 1), number) == number - 1


def test_keys_of_a_random_floor_are_spread_over_the_buckets():
    cells = np.random.default_rng(0).integers(0, 8, (4000, KEY_SIZE))
    buckets = [bucket_of_hash(np.uint64(hash_of(STEPS_PER_CELL * row)), 4100) for row in cells]
    fullest = np.bincount(buckets, minlength=4100).max()
    assert len(np.unique(buckets)) > 0.55 * 4100
    assert fullest < 12


def test_cells_of_a_hundred_times_more_keys_are_finer_by_the_eighth_root():
    assert cell_step(10**8, 0.5) / cell_step(10**6, 0.5) == pytest.approx(100.0 ** (-1.0 / KEY_SIZE))
    assert cell_step(8 * 10**6, 4.0) == pytest.approx(cell_step(10**6, 0.5))
    assert cell_step(0, 0.5) > 0
    assert cell_step(10**14, 0.5) > 0
