"""Odometry consistency check of poses."""

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


HERE, MOVED = T_MAP_ODOM, T_MAP_ODOM @ SE2(1.0, 0.0, 0.0)


def driven(way: float) -> SE2:
    return SE2(way, 0.1 * way, 0.2 * way)


def verdicts(*poses: tuple[float, SE2, SE2 | None]) -> list[bool]:
    """Return which poses are accepted, one after the other."""
    check = PoseConsistencyCheck()
    return [check.is_consistent(*pose) for pose in poses]


def test_poses_consistent_with_odometry_are_accepted() -> None:
    ways = [0.2 * step for step in range(20)]
    assert all(verdicts(*((0.5 * way, T_MAP_ODOM @ driven(way), driven(way)) for way in ways)))
    # Odometry may drift by a few percent.
    ways = [0.05 * step for step in range(600)]
    assert all(verdicts(*((2.0 * way, SE2(way, 0.0, 0.0), SE2(1.02 * way, 0.0, 0.0)) for way in ways)))


FAST, SEVEN, TWELVE = SE2(3.0 * SPEED_MAX, 0.0, 2.0), driven(7.0), driven(12.0)
FROM_7_TO_12 = SEVEN.inverse() @ TWELVE
END, STOOD = ACCEPT_AFTER, driven(0.0)
DROVE = T_MAP_ODOM @ driven(3.8)
AHEAD = DROVE @ SE2(1.0, 0.0, 0.0)
LATER = [(END + 1.1, AHEAD, None), (2.0 * END + 1.2, AHEAD, None)]
ON_THE_WAY = [(0.1 * step, T_MAP_ODOM @ driven(0.2 * step), None) for step in range(20)]


def poses(pose: SE2, odometry: SE2 | None, *stamps: float) -> list[tuple[float, SE2, SE2 | None]]:
    return [(stamp, pose, odometry) for stamp in stamps]


@pytest.mark.parametrize(
    ('steps', 'accepted'),
    [
        # A jump is rejected until the waiting time is over.
        ([*poses(HERE, STOOD, 0.0), *poses(MOVED, STOOD, 0.1, 1.0, END - 1.0, END + 0.2, END + 0.3)], '+---++'),
        # The old pose is accepted at once and restarts the waiting time.
        ([(0.0, HERE, STOOD), (1.0, MOVED, STOOD), (2.0, HERE, STOOD), (END + 1.5, MOVED, STOOD)], '+-+-'),
        # Without odometry a robot may drive but not jump, however long copied lamps shine.
        ([*ON_THE_WAY, *poses(AHEAD, None, 2.0, 5.0, END), (END + 1.0, DROVE, None), *LATER], '+' * 20 + '---+-+'),
        # After a gap in view it may be elsewhere.
        ([(0.0, HERE, None), (3.0, HERE @ FAST, None), (4.0, HERE @ SE2(20.0, 0.0, 2.0), None)], '++-'),
        # Odometry that comes late is taken up.
        ([(0.0, HERE, None), (0.1, HERE, SEVEN), (9.0, HERE @ FROM_7_TO_12, TWELVE), (9.1, HERE, TWELVE)], '+++-'),
    ],
)
def test_jumps_are_rejected_for_the_waiting_time(steps, accepted: str) -> None:
    assert ''.join('-+'[verdict] for verdict in verdicts(*steps)) == accepted


@pytest.mark.parametrize('has_odometry', [True, False])
def test_a_slowly_drifting_pose_is_rejected(has_odometry: bool) -> None:
    odometry, ways = STOOD if has_odometry else None, [0.29 * image for image in range(600)]
    accepted = verdicts(*((i / 60.0, T_MAP_ODOM @ SE2(way, 0.0, 0.0), odometry) for i, way in enumerate(ways)))
    # Without odometry it is a robot that drives, but no faster than robots do.
    assert max(w for w, yes in zip(ways, accepted) if yes) < JUMP_MAX + (0.0 if has_odometry else 10.0 * SPEED_MAX)


def test_a_slow_drift_is_not_faster_than_the_waiting_time() -> None:
    seconds = range(int(ACCEPT_AFTER))
    accepted = verdicts(*((float(s), T_MAP_ODOM @ SE2(0.1 * s, 0.0, 0.0), STOOD) for s in seconds))
    assert all(0.1 * s < JUMP_MAX * (1.0 + s / ANCHOR_TIME) for s, yes in zip(seconds, accepted) if yes)
