"""A path passes through its poses and interpolates between them."""

import math

import pytest

from shirube_bringup.render_worker import PiecewisePath
from shirube_core.geometry import SE2

PATH = PiecewisePath((0.0, 1.0, 3.0), (SE2(0, 0, 3.0), SE2(1, 2, -3.0), SE2(5, 2, -3.0)))


def test_it_goes_through_its_poses_and_stays_at_its_ends():
    for time, pose in zip((-1.0, *PATH.times, 9.0), (PATH.poses[0], *PATH.poses, PATH.poses[-1])):
        there = PATH.pose_at(time)
        assert there.distance_to(pose) < 1e-12
        assert abs(there.yaw_to(pose)) < 1e-12


def test_between_two_poses_it_is_in_the_middle_and_turns_the_short_way():
    middle = PATH.pose_at(0.5)
    assert (middle.x, middle.y) == (0.5, 1.0)
    assert math.cos(middle.yaw) == pytest.approx(-1.0)
