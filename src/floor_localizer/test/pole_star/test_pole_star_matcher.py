"""The whole pipeline on a small floor with known poses."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from floor_localizer.core.pole_star.pole_star_matcher import (
    NoPose,
    PoleStarMatcher,
    PoleStarPose,
    PoleStarSettings,
    build_address_matrix,
    match_rate,
)
from shirube_core.geometry import SE2

BLOCK = 0.0028
DENSITY = 5384.0
DOTS = np.random.default_rng(6).uniform(0.0, 1.0, (round(DENSITY), 2))
ADDRESSES = build_address_matrix(DOTS, BLOCK)


def test_every_occupied_block_holds_a_dot_and_the_floors_own_dots_match():
    own_blocks = {tuple(block) for block in np.floor((DOTS - ADDRESSES.origin) / BLOCK).astype(int)}
    assert ADDRESSES.occupied.sum() == len(own_blocks)
    assert match_rate(ADDRESSES, DOTS) == 1.0
    assert match_rate(ADDRESSES, np.vstack([DOTS[:3], [[-5.0, 0.5], [0.5, 5.0]]])) == pytest.approx(0.6)
    assert match_rate(ADDRESSES, np.empty((0, 2))) == 0.0


def test_dots_anywhere_match_as_often_as_blocks_are_occupied():
    points = np.random.default_rng(7).uniform(0.01, 0.99, (40000, 2))
    assert match_rate(ADDRESSES, points) == pytest.approx(1.0 - math.exp(-DENSITY * BLOCK**2), abs=0.004)


def test_dots_off_a_floor_without_gaps_do_not_match():
    full = build_address_matrix(np.argwhere(np.ones((5, 4))).astype(np.float64) * BLOCK, BLOCK)
    assert full.occupied.all()
    outside = np.array([[-0.5, 2.0], [2.0, -0.5], [5.5, 2.0], [2.0, 4.5]]) * BLOCK
    assert match_rate(full, outside) == 0.0


NOISE = 0.000383  # 1 px of the paper's camera [m]
FLOOR = np.random.default_rng(9).uniform(0.0, 0.9, (4361, 2))
MATCHER = PoleStarMatcher(FLOOR, PoleStarSettings())


def view_of(T_map_view, rng, missing=0.0, spurious=0.0, floor=FLOOR) -> tuple[NDArray, NDArray]:
    """Return image dots and the indices of their floor dots (-1: spurious)."""
    points = T_map_view.inverse().transform(floor)
    inside = np.flatnonzero(np.abs(points).max(axis=1) <= 0.045)
    kept = rng.permutation(inside)[round(missing * len(inside)) :]
    dirt = rng.uniform(-0.045, 0.045, (round(spurious * len(inside)), 2))
    image = np.vstack([points[kept], dirt])
    return image + rng.normal(0.0, NOISE, image.shape), np.concatenate([kept, np.full(len(dirt), -1)])


@pytest.mark.parametrize(('missing', 'spurious'), [(0.0, 0.0), (0.0, 0.5), (0.4, 0.0), (0.25, 0.5)])
@pytest.mark.parametrize('seed', range(3))
def test_the_pose_is_found(missing, spurious, seed):
    rng = np.random.default_rng(seed)
    T_map_view = SE2(*rng.uniform((0.07, 0.07, -np.pi), (0.83, 0.83, np.pi)))
    image, map_dots = view_of(T_map_view, rng, missing, spurious)
    found = MATCHER.match(image)
    assert isinstance(found, PoleStarPose)
    assert found.T_map_view.distance_to(T_map_view) < 0.002
    assert abs(found.T_map_view.yaw_to(T_map_view)) < np.radians(1.5)
    assert np.mean(map_dots[found.pairs[:, 0]] == found.pairs[:, 1]) > 0.8
    assert found.match_rate <= 1.0


def test_the_pose_follows_the_map():
    T_room_map = SE2(-3.0, 11.0, 2.5)
    image, _ = view_of(SE2(0.4, 0.5, -1.0), np.random.default_rng(10))
    here = MATCHER.match(image)
    there = PoleStarMatcher(T_room_map.transform(FLOOR), PoleStarSettings()).match(image)
    assert isinstance(here, PoleStarPose)
    assert isinstance(there, PoleStarPose)
    assert there.T_map_view.distance_to(T_room_map @ here.T_map_view) < 0.0005


@pytest.mark.parametrize('seed', range(12, 16))
def test_another_floor_has_no_pose(seed):
    rng = np.random.default_rng(seed)
    image, _ = view_of(SE2(0.45, 0.45, 0.0), rng, floor=rng.uniform(0.0, 0.9, FLOOR.shape))
    found = MATCHER.match(image)
    assert isinstance(found, NoPose)
    assert found.reason


@pytest.mark.parametrize('image', [
    view_of(SE2(0.45, 0.45, 0.3), np.random.default_rng(13))[0] * (1.0, -1.0),
    np.empty((0, 2)), np.zeros((3, 2)), np.zeros((9, 2)),
])  # fmt: skip
def test_a_mirrored_image_and_too_few_different_dots_have_no_pose(image):
    assert isinstance(MATCHER.match(image), NoPose)


def test_poses_come_in_order_of_their_match_rate_which_has_a_lower_bound():
    image, _ = view_of(SE2(0.4, 0.5, -1.0), np.random.default_rng(11), 0.25, 0.5)
    rates = [pose.match_rate for pose in MATCHER.congruent_poses(image)]
    assert rates == sorted(rates, reverse=True)
    found = PoleStarMatcher(FLOOR, PoleStarSettings(match_rate_min=0.9)).match(image)
    assert isinstance(found, NoPose)
    assert '0.900' in found.reason
