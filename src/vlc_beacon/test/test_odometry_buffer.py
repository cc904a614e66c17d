"""Odometry at the stamps of images."""

import numpy as np
import pytest

from shirube_core.geometry import SE2
from vlc_beacon.core.receiver.odometry_buffer import LampOdometry


def pose_after(seconds: float) -> SE2:
    return SE2(1.0, 2.0, 0.5) @ SE2.exp(0.3 * seconds, 0.0, 0.8 * seconds)


@pytest.fixture
def buffer() -> LampOdometry:
    made = LampOdometry()
    for k in range(11):
        made.add(5.0 + 0.1 * k, pose_after(0.1 * k))
    return made


@pytest.mark.parametrize('stamp', [5.0, 5.234, 5.9, 6.0, 6.1])
def test_an_arc_is_known_between_and_a_little_beyond_the_poses(buffer: LampOdometry, stamp: float) -> None:
    pose = buffer.pose_at(stamp)
    assert pose is not None
    assert pose.distance_to(pose_after(stamp - 5.0)) < 1e-9
    np.testing.assert_allclose(buffer.velocity_at(stamp), [0.3, 0.0, 0.8], atol=1e-9)


def test_far_from_all_poses_nothing_is_known(buffer: LampOdometry) -> None:
    assert LampOdometry().pose_at(1.0) is None
    for stamp in (4.5, 6.5):
        assert buffer.pose_at(stamp) is None
        np.testing.assert_array_equal(buffer.velocity_at(stamp), np.zeros(3))


def test_one_pose_gives_zero_velocity() -> None:
    buffer = LampOdometry()
    buffer.add(1.0, SE2(1.0, 2.0, 3.0))
    assert buffer.pose_at(1.1) == SE2(1.0, 2.0, 3.0)
    np.testing.assert_array_equal(buffer.velocity_at(1.1), np.zeros(3))
