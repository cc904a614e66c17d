"""Laws of the odometry buffer: constant twist, order of arrival, shift of time, limits, jumps and covariance."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shirube_core.geometry import SE2
from shirube_core.motion import NoPoseReason, OdometryBuffer, motion_between, motion_covariance

SECOND = 1_000_000_000
BEGIN = 1000 * SECOND
STAMPS = [BEGIN + k * SECOND // 50 for k in range(60)]
END = STAMPS[-1]
TWIST = (0.5, -0.1, 0.8)  # a second


def on_arc(stamp, twist=TWIST):
    seconds = (stamp - BEGIN) / SECOND
    return SE2(3.0, -2.0, 1.0) @ SE2.exp(*(seconds * v for v in twist))


def on_winding_path(stamp):
    seconds = (stamp - BEGIN) / SECOND
    return SE2(math.sin(seconds), 0.3 * math.cos(3.0 * seconds), 2.0 * math.sin(2.0 * seconds))


def buffer_of(stamps=STAMPS, pose_at=on_arc, **limits):
    buffer = OdometryBuffer(**limits)
    for stamp in stamps:
        assert buffer.add(stamp, pose_at(stamp)) is not None
    return buffer


def assert_same(found, expected, tolerance=1e-9):
    assert found.distance_to(expected) < tolerance
    assert abs(found.yaw_to(expected)) < tolerance


@given(st.integers(-SECOND // 4, round(1.43 * SECOND)), st.integers(1, 20))
def test_constant_twist_is_exact_along_the_arc_and_a_little_beyond(ahead, thin):
    buffer, stamp = buffer_of(STAMPS[::thin]), BEGIN + ahead
    if stamp <= STAMPS[::thin][-1] + SECOND // 4:
        assert_same(buffer.pose_at(stamp), on_arc(stamp))
        assert buffer.twist_at(stamp) == pytest.approx(TWIST)


@given(st.integers(0, round(1.4 * SECOND)), st.integers(0, round(1.4 * SECOND)))
def test_motions_compose_and_there_and_back_is_the_identity(one, other):
    buffer, a, b = buffer_of(pose_at=on_winding_path), BEGIN + one, BEGIN + other
    assert_same(buffer.motion(a, b) @ buffer.motion(b, a), SE2(0.0, 0.0, 0.0))
    assert_same(buffer.motion(BEGIN, a) @ buffer.motion(a, b), buffer.motion(BEGIN, b))


@given(st.integers(-(10**15), 10**15), st.integers(0, 3 * SECOND))
def test_a_shift_of_time_changes_nothing(shift, ahead):
    buffer, shifted = buffer_of(pose_at=on_winding_path), OdometryBuffer()
    for stamp in STAMPS:
        shifted.add(stamp + shift, on_winding_path(stamp))
    stamp = BEGIN + ahead
    assert shifted.pose_at(stamp + shift) == buffer.pose_at(stamp)
    assert shifted.motion(BEGIN + shift, stamp + shift) == buffer.motion(BEGIN, stamp)
    here, there = (motion_between(b.lookup(BEGIN + s), b.lookup(stamp + s)) for b, s in ((buffer, 0), (shifted, shift)))
    assert here == there


@given(st.permutations(range(60)), st.integers(-SECOND, 3 * SECOND))
@settings(max_examples=30, deadline=None)
def test_the_order_of_arrival_does_not_matter(order, ahead):
    late, buffer = (buffer_of([STAMPS[k] for k in o], on_winding_path) for o in (order, range(60)))
    stamp = BEGIN + ahead
    assert late.lookup(stamp) == buffer.lookup(stamp)
    assert late.pose_at(stamp) == buffer.pose_at(stamp)


@given(st.integers(0, 59), st.integers(0, round(1.2 * SECOND)))
def test_lookups_before_the_stamp_that_add_returns_stay(k, ahead):
    buffer = buffer_of([stamp for stamp in STAMPS if stamp != STAMPS[k]], on_winding_path)
    before = buffer.lookup(BEGIN + ahead)
    changed = buffer.add(STAMPS[k], on_winding_path(STAMPS[k]))
    assert buffer.lookup(BEGIN + ahead) == before or BEGIN + ahead >= changed


def test_beyond_the_limits_there_is_no_pose_but_a_reason():
    quarter, buffer = SECOND // 4, buffer_of()
    assert isinstance(buffer.pose_at(END + quarter), SE2)
    new, old = (END + quarter + 1, NoPoseReason.TOO_NEW), (BEGIN - quarter - 1, NoPoseReason.TOO_OLD)
    for stamp, reason in (new, old):
        assert buffer.pose_at(stamp) is buffer.motion(BEGIN, stamp) is buffer.motion(stamp, BEGIN) is reason
        assert buffer.twist_at(stamp) == (0.0, 0.0, 0.0)
    assert buffer_of(extrapolation_max=0).pose_at(END + 1) is NoPoseReason.TOO_NEW
    assert OdometryBuffer().pose_at(BEGIN) is NoPoseReason.EMPTY


def test_within_a_gap_nothing_is_known_and_after_it_the_pose_stays():
    buffer = buffer_of([BEGIN, BEGIN + SECOND])
    assert buffer.pose_at(BEGIN + SECOND // 2) is NoPoseReason.GAP
    assert_same(buffer.motion(BEGIN, BEGIN + SECOND), on_arc(BEGIN).inverse() @ on_arc(BEGIN + SECOND))
    assert buffer.pose_at(BEGIN + SECOND + SECOND // 5) == on_arc(BEGIN + SECOND)
    assert buffer_of([BEGIN]).pose_at(BEGIN + SECOND // 5) == on_arc(BEGIN)


def test_two_messages_of_nearly_the_same_time_give_no_velocity():
    buffer = buffer_of()
    buffer.add(END + 2000, on_arc(END) @ SE2(1e-3, 0.0, 0.0))
    assert buffer.twist_at(END + SECOND // 20) == pytest.approx(TWIST)
    assert buffer.pose_at(END + SECOND // 20).distance_to(on_arc(END + SECOND // 20)) < 1.1e-3


def restarted(stamp):
    return on_arc(stamp) if stamp < STAMPS[25] else SE2(3e-10 * (stamp - STAMPS[25]), 0.0, 0.0)


def test_a_jump_is_a_gap_and_not_motion():
    buffer = buffer_of(pose_at=restarted)
    motion = motion_between(buffer.lookup(STAMPS[24]), buffer.lookup(STAMPS[25]))
    assert (motion.x, motion.y, motion.yaw) == (0.0, 0.0, 0.0)
    assert motion.odometry_gap == pytest.approx(0.02)
    assert buffer.pose_at(STAMPS[25]) == restarted(STAMPS[25])
    assert buffer.pose_at(STAMPS[24] + 1).distance_to(on_arc(STAMPS[24])) < 1e-3
    assert buffer.motion(STAMPS[24], STAMPS[25]) is NoPoseReason.JUMPED
    assert_same(buffer.motion(STAMPS[26], STAMPS[36]), SE2(0.06, 0.0, 0.0))
    turned = buffer_of(pose_at=lambda stamp: SE2(0.0, 0.0, 0.0 if stamp < STAMPS[25] else 1.0))
    assert turned.motion(STAMPS[24], STAMPS[25]) is NoPoseReason.JUMPED


@pytest.mark.parametrize(('first', 'last'), [(0.0, 1.0), (0.113, 0.977), (0.5, 0.501)])
def test_a_motion_is_that_of_the_wheels(first, last):
    buffer = buffer_of()
    a, b = (buffer.lookup(BEGIN + round(s * SECOND)) for s in (first, last))
    motion = motion_between(a, b)
    assert_same(
        SE2(0.0, 0.0, -a.yaw) @ SE2(motion.x, motion.y, motion.yaw + a.yaw),
        SE2.exp(*((last - first) * v for v in TWIST)),
    )
    assert motion.distance == pytest.approx((last - first) * math.hypot(*TWIST[:2]))
    assert motion.rotation == pytest.approx((last - first) * TWIST[2])
    assert motion.path_length(1.0) == pytest.approx(motion.distance + motion.rotation)


def test_the_covariance_is_that_of_the_steps_one_by_one():
    buffer, noise_xy, noise_yaw = buffer_of(), 0.05, 0.04
    cumulative = [buffer.lookup(stamp) for stamp in STAMPS]
    total = np.zeros((3, 3))
    for a, b in pairwise(cumulative):
        F = np.eye(3)
        F[0, 2], F[1, 2] = -(b.y - a.y), b.x - a.x
        distance, rotation = b.distance - a.distance, b.rotation - a.rotation
        step = np.diag([noise_xy**2 * distance] * 2 + [noise_yaw**2 * (distance + rotation)])
        total = F @ total @ F.T + step
    covariance = motion_covariance(cumulative[0], cumulative[-1], noise_xy, noise_yaw)
    np.testing.assert_allclose(covariance, total, atol=1e-12)


def test_odometry_that_begins_again_after_a_silence_may_have_missed_what_was_driven():
    missing = range(20, 50)  # 0.6 s
    stamps = [STAMPS[k] for k in range(60) if k not in missing]
    for kept, shortest, longest in ((stamps, 0.3, 0.62), (STAMPS, 0.0, 0.0)):
        buffer = buffer_of(kept, lambda _: SE2(1.0, 2.0, 0.5))
        motion = motion_between(buffer.lookup(STAMPS[10]), buffer.lookup(STAMPS[55]))
        assert motion.distance == 0.0
        assert shortest <= motion.odometry_gap <= longest
        half = motion_between(buffer.lookup(STAMPS[10]), buffer.lookup(STAMPS[35]))
        assert half.odometry_gap <= longest / 2


def test_the_robot_goes_on_for_a_moment_and_without_odometry_all_time_is_a_gap():
    empty, buffer = OdometryBuffer(), buffer_of()
    a, b, c = (buffer.lookup(END + round(s * SECOND)) for s in (0.0, 0.1, 5.0))
    assert math.hypot(b.x - a.x, b.y - a.y) == pytest.approx(0.051, abs=1e-3)
    assert motion_between(a, b).odometry_gap == 0.0
    assert motion_between(a, c).odometry_gap == pytest.approx(4.75)
    assert empty.latest is None
    assert buffer.latest == END
    for each in (empty, buffer):
        motion = motion_between(each.lookup(BEGIN - 3 * SECOND), each.lookup(BEGIN - SECOND))
        assert (motion.distance, motion.odometry_gap, motion.duration) == (0.0, 2.0, 2.0)


def test_a_stamp_that_is_there_or_older_than_the_history_is_left_out():
    buffer = buffer_of(history=SECOND)
    before = buffer.lookup(END)
    assert buffer.add(STAMPS[30], SE2(9.0, 9.0, 0.0)) is None
    assert buffer.add(END - SECOND - 1, SE2(9.0, 9.0, 0.0)) is None
    assert buffer.lookup(END) == before


def test_dropping_the_past_does_not_change_the_present():
    stamps = [BEGIN + k * SECOND // 100 for k in range(2000)]
    buffer, whole = buffer_of(stamps, history=SECOND), buffer_of(stamps)
    assert len(buffer._stamps) < 500
    at = BEGIN + 19 * SECOND + 555
    assert buffer.lookup(at) == whole.lookup(at)
    assert buffer.pose_at(at) == whole.pose_at(at)
    assert buffer.pose_at(BEGIN) is NoPoseReason.TOO_OLD


def test_a_buffer_of_jumps_is_bounded():
    stamps = [BEGIN + k * SECOND // 100 for k in range(2000)]
    buffer = buffer_of(stamps, lambda stamp: SE2(1e-6 * (stamp % 7) * stamp, 0.0, 0.0), history=SECOND)
    assert len(buffer._jump_stamps) < 500
