"""Frames get the pose at their stamp, or are dropped and counted with the reason."""

from __future__ import annotations

import pytest

from reward_planner.core.mapping.mapping_settings import MappingSettings
from reward_planner.core.mapping.pose_trail import PoseTrail
from reward_planner.core.mapping.waiting_frames import DropReason, WaitingFrames
from shirube_geometry import PlanarPose


def drive(trail, start, end):
    """Poses at 20 Hz of a robot that drives along x at 1 m/s."""
    for k in range(round(20 * start), round(20 * end) + 1):
        trail.add(k / 20.0, PlanarPose(k / 20.0, 0.0, 0.0))


def test_a_frame_waits_for_the_pose_of_its_instant():
    trail, frames = PoseTrail(MappingSettings()), WaitingFrames[str](0.5)
    drive(trail, 0.0, 1.0)
    frames.put(1.13, 1.15, 'a')
    assert frames.take(1.2, trail) == []
    drive(trail, 1.05, 1.2)
    ((stamp, frame, pose),) = frames.take(1.25, trail)
    assert (stamp, frame) == (1.13, 'a')
    assert pose.x == pytest.approx(1.13)
    assert len(frames) == 0
    assert not frames.dropped


def test_a_frame_whose_pose_does_not_come_is_dropped_and_counted():
    trail, frames = PoseTrail(MappingSettings()), WaitingFrames[str](0.5)
    frames.put(1.0, 1.0, 'a')
    assert frames.take(1.4, trail) == []
    assert len(frames) == 1
    assert frames.take(1.6, trail) == []
    assert frames.dropped == {DropReason.POSE_LATE: 1}


def test_a_frame_from_before_the_first_pose_is_dropped_at_once():
    trail, frames = PoseTrail(MappingSettings()), WaitingFrames[str](0.5)
    drive(trail, 1.0, 2.0)
    frames.put(0.9, 2.0, 'a')
    assert frames.take(2.0, trail) == []
    assert frames.dropped == {DropReason.POSE_MISSING: 1}


def test_frames_within_a_jump_are_dropped_and_later_ones_taken():
    trail, frames = PoseTrail(MappingSettings()), WaitingFrames[int](5.0)
    drive(trail, 0.0, 1.0)
    taken = []
    for k in range(8, 32):
        frames.put(0.1 * k, 0.1 * k, k)
        if k > 10:
            for stamp in (0.1 * k - 0.05, 0.1 * k):
                trail.add(stamp, PlanarPose(30.0 + stamp, 0.0, 0.0))
        taken += frames.take(0.1 * k, trail)
    assert [frame for _, frame, _ in taken] == [8, 9, 10, *range(21, 32)]
    assert frames.dropped[DropReason.POSE_MISSING] == 10


def test_frames_come_out_in_the_order_in_which_they_came():
    trail, frames = PoseTrail(MappingSettings()), WaitingFrames[int](0.5)
    drive(trail, 0.0, 2.0)
    for k in range(10):
        frames.put(0.1 * k, 1.0, k)
    assert [frame for _, frame, _ in frames.take(1.1, trail)] == list(range(10))


def test_the_queue_is_bounded():
    frames = WaitingFrames[int](1e9)
    for k in range(100):
        frames.put(0.1 * k, 0.1 * k, k)
    assert len(frames) == 32
    assert frames.dropped == {DropReason.TOO_MANY: 68}


def test_a_clock_that_jumps_back_keeps_no_frame_for_ever():
    trail, frames = PoseTrail(MappingSettings()), WaitingFrames[str](0.5)
    frames.put(100.0, 100.0, 'old')
    assert frames.take(3.0, trail) == []
    assert frames.dropped == {DropReason.POSE_LATE: 1}
