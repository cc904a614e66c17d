"""Odometry at the stamps of images."""

from __future__ import annotations

import numpy as np
import pytest

from shirube_core.geometry import SE2
from vlc_beacon.core.receiver.odometry_buffer import OdometryBuffer


def trail_of_a_straight_drive() -> OdometryBuffer:
    trail = OdometryBuffer()
    for step in range(11):
        trail.add(5.0 + 0.1 * step, SE2(1.0, 2.0, 0.5) @ SE2(0.03 * step, 0.0, 0.0))
    return trail


@pytest.mark.parametrize('stamp', [5.0, 5.234, 5.9, 6.0, 6.1])
def test_a_straight_drive_is_known_between_and_a_little_beyond_the_poses(stamp: float) -> None:
    trail = trail_of_a_straight_drive()
    pose = trail.pose_at(stamp)
    assert pose is not None
    truth = SE2(1.0, 2.0, 0.5) @ SE2(0.3 * (stamp - 5.0), 0.0, 0.0)
    assert pose.distance_to(truth) < 1e-9
    np.testing.assert_allclose(trail.velocity_at(stamp), [0.3, 0.0, 0.0], atol=1e-9)


def test_far_from_all_poses_nothing_is_known() -> None:
    assert OdometryBuffer().pose_at(1.0) is None
    trail = trail_of_a_straight_drive()
    for stamp in (4.5, 6.5):
        assert trail.pose_at(stamp) is None
        np.testing.assert_array_equal(trail.velocity_at(stamp), np.zeros(3))


def test_one_pose_gives_zero_velocity() -> None:
    trail = OdometryBuffer()
    trail.add(1.0, SE2(1.0, 2.0, 3.0))
    assert trail.pose_at(1.1) == SE2(1.0, 2.0, 3.0)
    np.testing.assert_array_equal(trail.velocity_at(1.1), np.zeros(3))


def test_poses_of_nearly_the_same_time_do_not_give_a_large_velocity() -> None:
    trail = trail_of_a_straight_drive()
    trail.add(6.0 + 2e-6, SE2(1.0, 2.0, 0.5) @ SE2(0.301, 0.0, 0.0))
    np.testing.assert_allclose(trail.velocity_at(6.05), [0.3, 0.0, 0.0], atol=1e-9)
