"""What must not change a key, and packed comparison against a plain one."""

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
    OTHERS,
    X_LOWER,
    X_STEPS,
    Y_LOWER,
    Y_STEPS,
    base_coordinates,
    bucket_of_hash,
    cell_sides,
    hash_of_code,
    imbalance,
    is_within,
    lane_hashes,
    pack,
    pack_coordinates,
    sort_by_x,
    to_steps,
    turn_around,
    unpack,
)

# The first call compiles.
UNHURRIED = settings(deadline=None)
STEPS = hnp.arrays(np.int64, LANES, elements=st.integers(0, 127))
IN_LENS = np.array([[0.2, 0.5], [0.45, -0.3], [0.6, 0.1], [0.85, -0.4]])


def packed(steps):
    """As the compiled search holds it; outside of it numba hands out plain integers."""
    return np.uint64(pack(steps))


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


def test_key_does_not_depend_on_the_order_of_the_dots_once_sorted():
    keys = set()
    for order in ([0, 1, 2, 3], [3, 2, 1, 0], [1, 3, 0, 2]):
        xy = IN_LENS[order].copy()
        sort_by_x(xy)
        keys.add(int(pack_coordinates(xy)))
    assert len(keys) == 1


def test_key_holds_the_coordinates_to_half_a_step():
    code = int(pack_coordinates(IN_LENS))
    lanes = np.array(list(code.to_bytes(LANES, 'big'))).reshape(OTHERS, 2)
    x, y = lanes[:, 0] / X_STEPS + X_LOWER, lanes[:, 1] / Y_STEPS + Y_LOWER
    assert np.max(np.abs(x - IN_LENS[:, 0])) <= 0.5001 / X_STEPS
    assert np.max(np.abs(y - IN_LENS[:, 1])) <= 0.5001 / Y_STEPS


def test_coordinates_beyond_the_range_stop_at_its_ends():
    assert to_steps(-5.0, X_LOWER, X_STEPS) == 0
    assert to_steps(5.0, X_LOWER, X_STEPS) == 127


@UNHURRIED
@given(STEPS)
def test_packed_steps_lie_in_bytes_from_high_to_low(steps):
    assert int(pack(steps)).to_bytes(LANES, 'big') == bytes(steps.tolist())


@UNHURRIED
@given(STEPS, STEPS, STEPS)
def test_packed_comparison_is_that_of_every_lane(steps, lower, upper):
    plain = bool(np.all((lower <= steps) & (steps <= upper)))
    assert is_within(packed(steps), packed(lower), packed(upper)) == plain


@UNHURRIED
@given(STEPS, STEPS, STEPS)
def test_what_lies_between_is_within(a, b, c):
    lower, middle, upper = np.sort([a, b, c], axis=0)
    assert is_within(packed(middle), packed(lower), packed(upper))


@UNHURRIED
@given(STEPS)
def test_unpacking_is_the_inverse_of_packing(steps):
    unpacked = np.empty(LANES, dtype=np.int64)
    unpack(packed(steps), unpacked)
    np.testing.assert_array_equal(unpacked, steps)


def hash_of(steps, x_cell, y_cell):
    return np.uint64(hash_of_code(packed(steps), lane_hashes(x_cell, y_cell)))


@UNHURRIED
@given(STEPS, STEPS)
def test_keys_of_the_same_cell_have_the_same_hash_and_others_another(steps, others):
    cells = np.where(np.arange(LANES) % 2 == 0, 16, 10)
    same = bool(np.all(steps // cells == others // cells))
    assert (hash_of(steps, 16, 10) == hash_of(others, 16, 10)) == same


@UNHURRIED
@given(STEPS, st.integers(0, LANES - 1))
def test_the_next_cell_along_a_lane_is_an_addition_away(steps, lane):
    cells = np.where(np.arange(LANES) % 2 == 0, 16, 10)
    steps[lane] = min(steps[lane], 127 - cells[lane])
    beyond = steps + cells * (np.arange(LANES) == lane)
    expected = (int(hash_of(steps, 16, 10)) + int(LANE_HASHES[lane])) % 2**64
    assert int(hash_of(beyond, 16, 10)) == expected


def test_keys_of_a_random_floor_are_spread_over_the_buckets():
    cells = np.random.default_rng(0).integers(0, 8, (4000, LANES))
    buckets = [bucket_of_hash(hash_of(16 * row // 2, 8, 8), 12) for row in cells]
    fullest = np.bincount(buckets, minlength=4096).max()
    assert len(np.unique(buckets)) > 0.55 * 4096
    assert fullest < 12


def test_cells_of_a_hundred_times_more_keys_are_finer_by_the_eighth_root():
    few, many = np.array(cell_sides(10**6)), np.array(cell_sides(10**8))
    np.testing.assert_allclose(many / few, 100.0 ** (-1.0 / LANES), atol=0.06)
    assert min(cell_sides(0)) > 0
    assert min(cell_sides(10**12)) > 0
