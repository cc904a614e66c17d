"""The match rate on the address grid."""

import math

import numpy as np
import pytest

from floor_localizer.core.pole_star.pole_star_matcher import build_address_matrix, match_rate

BLOCK = 0.0028
DENSITY = 5384.0
FLOOR = np.random.default_rng(6).uniform(0.0, 1.0, (round(DENSITY), 2))
ADDRESSES = build_address_matrix(FLOOR, BLOCK)


def test_the_floors_own_dots_match() -> None:
    assert match_rate(ADDRESSES, FLOOR) == 1.0


def test_every_occupied_block_holds_a_dot() -> None:
    own_blocks = {tuple(block) for block in np.floor((FLOOR - ADDRESSES.origin) / BLOCK).astype(int)}
    assert ADDRESSES.occupied.sum() == len(own_blocks)


def test_dots_anywhere_match_as_often_as_blocks_are_occupied() -> None:
    points = np.random.default_rng(7).uniform(0.01, 0.99, (40000, 2))
    assert match_rate(ADDRESSES, points) == pytest.approx(1.0 - math.exp(-DENSITY * BLOCK**2), abs=0.004)


def test_the_rate_is_a_fraction_of_all_dots() -> None:
    points = np.vstack([FLOOR[:3], [[-5.0, 0.5], [0.5, 5.0]]])
    assert match_rate(ADDRESSES, points) == pytest.approx(0.6)


def test_dots_off_a_floor_without_gaps_do_not_match() -> None:
    full = build_address_matrix(np.argwhere(np.ones((5, 4))).astype(np.float64) * BLOCK, BLOCK)
    assert full.occupied.all()
    outside = np.array([[-0.5, 2.0], [2.0, -0.5], [5.5, 2.0], [2.0, 4.5]]) * BLOCK
    assert match_rate(full, outside) == 0.0


def test_no_dots_do_not_match() -> None:
    assert match_rate(ADDRESSES, np.empty((0, 2))) == 0.0
