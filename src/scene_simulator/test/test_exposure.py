"""Times of rows and frames, and poses during a frame, written out by hand."""

import math

import numpy as np
import pytest

from scene_simulator.errors import SceneError
from scene_simulator.imaging.exposure import CameraClock, CameraMotion, CameraPose, Shutter, camera_pose
from shirube_core.geometry import SE2, CameraMount, matrix_from_rpy

ROLLING = Shutter(exposure=60e-6, row_time=9e-6)


@pytest.mark.parametrize(('shutter', 'first'), [(ROLLING, [900e-6, 909e-6, 918e-6]), (Shutter(60e-6), [0.0] * 3)])
def test_a_row_starts_its_row_times_after_the_stamp(shutter: Shutter, first: list[float]) -> None:
    cuts = shutter.exposure_boundaries(7.0, slice(100, 103), 3)
    expected = 7.0 + np.array(first)[:, None] + np.array([0.0, 20e-6, 40e-6, 60e-6])
    np.testing.assert_allclose(cuts, expected, atol=1e-12)


def test_the_middle_of_a_frame_is_between_its_first_start_and_its_last_end() -> None:
    end = ROLLING.frame_end(3.0, 1024)
    assert end == pytest.approx(3.0 + 1023 * 9e-6 + 60e-6, abs=1e-12)
    assert ROLLING.frame_middle(3.0, 1024) == pytest.approx(0.5 * (3.0 + end), abs=1e-12)
    assert ROLLING.row_middle(3.0, 0) == pytest.approx(3.0 + 30e-6, abs=1e-12)


@pytest.mark.parametrize(
    ('exposure', 'row_time'), [(0.0, 0.0), (-1e-3, 0.0), (1e-3, -1e-6), (float('nan'), 0.0), (1e-3, float('inf'))]
)
def test_times_that_no_shutter_has_are_refused(exposure: float, row_time: float) -> None:
    with pytest.raises(SceneError, match='exposure'):
        Shutter(exposure, row_time)


def test_an_ideal_clock_has_even_ticks_and_true_stamps() -> None:
    starts, stamps = CameraClock(60.0).frames(2.0, np.random.default_rng(0))
    np.testing.assert_allclose(starts, np.arange(120) / 60.0, atol=1e-12)
    np.testing.assert_array_equal(stamps, starts)


def test_the_jitter_is_as_large_as_asked_for() -> None:
    clock = CameraClock(60.0, stamp_jitter=50e-6)
    starts, stamps = clock.frames(300.0, np.random.default_rng(1))
    assert len(starts) == 18_000
    assert (stamps - starts).std() == pytest.approx(50e-6, rel=0.05)
    np.testing.assert_allclose(starts * 60.0, np.rint(starts * 60.0), atol=1e-9)


@pytest.mark.parametrize(
    ('rate', 'jitter', 'words'), [(0.0, 0.0, 'camera'), (60.0, -1.0, 'camera'), (60.0, 0.0, 'seconds')]
)
def test_clocks_and_recordings_that_cannot_be_are_refused(rate: float, jitter: float, words: str) -> None:
    with pytest.raises(SceneError, match=words):
        CameraClock(rate, jitter).frames(0.0, np.random.default_rng(0))


MOUNT = CameraMount((0.1, -0.05, 0.4), (0.02, -0.01, math.pi / 2.0))


def moving(time: float) -> CameraPose:
    """A robot that drives 1 m/s in a bend of 1.5 rad/s."""
    return camera_pose(SE2(math.sin(1.5 * time) / 1.5, 0.2, 1.5 * time), MOUNT)


def test_a_camera_is_where_the_robot_carries_it() -> None:
    robot = SE2(1.0, 2.0, math.pi / 2.0)
    pose = camera_pose(robot, MOUNT)
    # A quarter turn to the left takes ahead to +y and left to -x.
    np.testing.assert_allclose(pose.position, [1.0 + 0.05, 2.0 + 0.1, 0.4], atol=1e-12)
    np.testing.assert_allclose(pose.rotation, matrix_from_rpy((0.0, 0.0, robot.yaw)) @ MOUNT.rotation)


def test_poses_between_the_knots_are_the_true_ones() -> None:
    motion = CameraMotion(moving, 1.0, 1.016)
    times = np.linspace(1.0, 1.016, 41)
    positions, rotations = motion.poses(times)
    for time, position, rotation in zip(times, positions, rotations, strict=True):
        true = moving(float(time))
        np.testing.assert_allclose(position, true.position, atol=5e-6)
        np.testing.assert_allclose(rotation, true.rotation, atol=1e-9)
    np.testing.assert_array_equal(motion.pose(float(times[7])).position, positions[7])
