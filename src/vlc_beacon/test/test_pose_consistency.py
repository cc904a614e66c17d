"""Odometry consistency check of poses."""

from __future__ import annotations

import pytest

from shirube_core.geometry import SE2
from vlc_beacon.core.receiver.pose_consistency import (
    ACCEPT_AFTER,
    ANCHOR_TIME,
    JUMP_MAX,
    SPEED_MAX,
    PoseConsistencyCheck,
)

T_MAP_ODOM = SE2(3.0, -1.0, 0.7)


def driven(way: float) -> SE2:
    return SE2(way, 0.1 * way, 0.2 * way)


def test_poses_consistent_with_odometry_are_accepted() -> None:
    place = PoseConsistencyCheck()
    for step in range(20):
        assert place.is_consistent(0.1 * step, T_MAP_ODOM @ driven(0.2 * step), driven(0.2 * step))


def test_a_jump_is_rejected_until_the_waiting_time_is_over() -> None:
    place, moved = PoseConsistencyCheck(), SE2(1.0, 0.0, 0.0)
    assert place.is_consistent(0.0, T_MAP_ODOM, driven(0.0))
    for stamp in (0.1, 1.0, ACCEPT_AFTER - 1.0):
        assert not place.is_consistent(stamp, T_MAP_ODOM @ moved, driven(0.0))
    assert place.is_consistent(ACCEPT_AFTER + 0.2, T_MAP_ODOM @ moved, driven(0.0))
    assert place.is_consistent(ACCEPT_AFTER + 0.3, T_MAP_ODOM @ moved, driven(0.0))


def test_the_old_pose_is_accepted_at_once_and_restarts_the_waiting_time() -> None:
    place, moved = PoseConsistencyCheck(), SE2(1.0, 0.0, 0.0)
    assert place.is_consistent(0.0, T_MAP_ODOM, driven(0.0))
    assert not place.is_consistent(1.0, T_MAP_ODOM @ moved, driven(0.0))
    assert place.is_consistent(2.0, T_MAP_ODOM, driven(0.0))
    assert not place.is_consistent(ACCEPT_AFTER + 1.5, T_MAP_ODOM @ moved, driven(0.0))


def test_without_odometry_a_robot_may_drive_but_not_jump() -> None:
    place, moved = PoseConsistencyCheck(), SE2(1.0, 0.0, 0.0)
    for step in range(20):
        assert place.is_consistent(0.1 * step, T_MAP_ODOM @ driven(0.2 * step), None)
    here = T_MAP_ODOM @ driven(3.8)
    # However long copied lamps shine, the way that a robot could have driven meanwhile does not grow.
    for stamp in (2.0, 5.0, ACCEPT_AFTER):
        assert not place.is_consistent(stamp, here @ moved, None)
    assert place.is_consistent(ACCEPT_AFTER + 1.0, here, None)
    assert not place.is_consistent(ACCEPT_AFTER + 1.1, here @ moved, None)
    assert place.is_consistent(2.0 * ACCEPT_AFTER + 1.2, here @ moved, None)


def test_without_odometry_a_robot_may_be_elsewhere_after_a_gap_in_view() -> None:
    place = PoseConsistencyCheck()
    assert place.is_consistent(0.0, T_MAP_ODOM, None)
    assert place.is_consistent(3.0, T_MAP_ODOM @ SE2(3.0 * SPEED_MAX, 0.0, 2.0), None)
    assert not place.is_consistent(4.0, T_MAP_ODOM @ SE2(20.0, 0.0, 2.0), None)


def test_odometry_that_comes_late_is_taken_up() -> None:
    place = PoseConsistencyCheck()
    assert place.is_consistent(0.0, T_MAP_ODOM, None)
    assert place.is_consistent(0.1, T_MAP_ODOM, driven(7.0))
    assert place.is_consistent(9.0, T_MAP_ODOM @ driven(7.0).inverse() @ driven(12.0), driven(12.0))
    assert not place.is_consistent(9.1, T_MAP_ODOM, driven(12.0))


@pytest.mark.parametrize('has_odometry', [True, False])
def test_a_slowly_drifting_pose_is_rejected(has_odometry: bool) -> None:
    place, farthest = PoseConsistencyCheck(), 0.0
    for image in range(600):
        stamp, way = image / 60.0, 0.29 * image
        odometry = driven(0.0) if has_odometry else None
        if place.is_consistent(stamp, T_MAP_ODOM @ SE2(way, 0.0, 0.0), odometry):
            farthest = way
    # Without odometry it is a robot that drives, but no faster than robots do.
    assert farthest < (JUMP_MAX if has_odometry else JUMP_MAX + 10.0 * SPEED_MAX)


def test_a_slow_drift_is_not_faster_than_the_waiting_time() -> None:
    place, farthest = PoseConsistencyCheck(), 0.0
    for second in range(120):
        way = 0.1 * second
        if place.is_consistent(float(second), T_MAP_ODOM @ SE2(way, 0.0, 0.0), driven(0.0)):
            farthest = max(farthest, way)
        if second < ACCEPT_AFTER:
            assert farthest < JUMP_MAX * (1.0 + second / ANCHOR_TIME)


def test_odometry_that_drifts_by_a_few_percent_is_followed() -> None:
    place = PoseConsistencyCheck()
    for step in range(600):
        odometry = SE2(1.02 * 0.05 * step, 0.0, 0.0)
        assert place.is_consistent(0.1 * step, SE2(0.05 * step, 0.0, 0.0), odometry)
