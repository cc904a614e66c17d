"""Odometry at the stamps of images; its interpolation is tested in shirube_core."""

import numpy as np

from shirube_core.geometry import SE2
from vlc_beacon.core.receiver.beacon_receiver import LampOdometry


def pose_after(seconds: float) -> SE2:
    return SE2(1.0, 2.0, 0.5) @ SE2.exp(0.3 * seconds, 0.0, 0.8 * seconds)


def test_poses_and_velocities_are_known_near_poses_and_jumps_are_noticed() -> None:
    buffer = LampOdometry()
    assert buffer.pose_at(1.0) is None
    for k in range(11):
        buffer.add(5.0 + 0.1 * k, pose_after(0.1 * k))
    for stamp in (5.0, 5.234, 6.0, 6.1):
        assert buffer.pose_at(stamp).distance_to(pose_after(stamp - 5.0)) < 1e-9
        np.testing.assert_allclose(buffer.velocity_at(stamp), [0.3, 0.0, 0.8], atol=1e-9)
    for stamp in (4.5, 6.5):
        assert buffer.pose_at(stamp) is None
        np.testing.assert_array_equal(buffer.velocity_at(stamp), np.zeros(3))
    buffer.add(6.1, pose_after(1.1) @ SE2(0.0, 1.0, 0.0))
    assert [buffer.has_jumped(5.5, stamp) for stamp in (5.0, 6.0, 6.05, 6.1, 6.2)] == [False] * 3 + [True] * 2
