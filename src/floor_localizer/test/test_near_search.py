"""Poses within the prior are found, other poses are not."""

from __future__ import annotations

import math

import numpy as np
import pytest
from search_scenes import new_search_for, scene

from floor_localizer.core.constellation.pair_search import search_near
from shirube_core.geometry import SE2


def near(indexed, dots, expected, radius, turn, pairs=12):
    search = new_search_for(dots, indexed)
    place = np.array([expected.x, expected.y, expected.yaw])
    return search_near(indexed.grid, dots, search, place, radius, turn, pairs), search


@pytest.mark.parametrize('radius', [0.003, 0.03])
@pytest.mark.parametrize('turn', [0.02, 0.4, 2.0, math.pi])
def test_a_pose_within_reach_is_found(floor, indexed_floor, radius, turn):
    rng = np.random.default_rng(0)
    for seed in range(4):
        pose, _, dots = scene(floor, indexed_floor, seed, missing=0.3, spurious=8)
        angle = rng.uniform(-math.pi, math.pi)
        shift = 0.9 * radius * np.array([math.cos(angle), math.sin(angle)])
        expected = SE2(pose.x + shift[0], pose.y + shift[1], pose.yaw + rng.uniform(-0.9, 0.9) * turn)
        found, search = near(indexed_floor, dots, expected, radius, turn)
        assert found
        assert search.best.pose.distance_to(pose) < 0.001


def test_a_pose_far_off_is_not_found(floor, indexed_floor):
    pose, _, dots = scene(floor, indexed_floor, 1)
    assert not near(indexed_floor, dots, SE2(pose.x, pose.y + 0.05, pose.yaw), 0.01, 0.1)[0]


def test_another_heading_is_not_found(floor, indexed_floor):
    pose, _, dots = scene(floor, indexed_floor, 1)
    assert not near(indexed_floor, dots, SE2(pose.x, pose.y, pose.yaw + 0.5), 0.01, 0.1)[0]


def test_without_pairs_nothing_is_found(floor, indexed_floor):
    pose, _, dots = scene(floor, indexed_floor, 1)
    assert not near(indexed_floor, dots, pose, 0.01, 0.1, pairs=0)[0]
