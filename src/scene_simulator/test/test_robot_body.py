"""The body's motion stays within its bounds, moves the camera, and is read with errors."""

import math

import numpy as np
import pytest

from scene_simulator.robot.leg_drive import Suspension, TiltErrors, apply_body_motion, simulate_tilt
from shirube_core.geometry import CameraMount

AT_REST = CameraMount()
SPRINGS = Suspension(seed=3)
MOTIONS = np.array([SPRINGS.motion_at(time) for time in np.arange(0.0, 60.0, 0.1)])


def test_the_motion_is_slow_keeps_its_bounds_and_uses_them() -> None:
    heave, roll, pitch = MOTIONS.T
    assert 0.5 * 0.0026 < np.abs(heave).max() <= 0.0026
    tilt = np.hypot(roll, pitch)
    assert math.radians(0.4) < tilt.max() <= math.radians(1.0)
    assert np.abs(np.diff(MOTIONS[:, 0])).max() < 0.0004
    assert np.abs(np.diff(MOTIONS[:, 1:], axis=0)).max() < math.radians(0.2)


def test_a_camera_that_looks_down_at_base_link_keeps_looking_there() -> None:
    for time in (0.0, 7.3, 31.0):
        mount = SPRINGS.mount_at(time, AT_REST)
        heave, roll, pitch = SPRINGS.motion_at(time)
        looks_at = mount.floor_points_from_rays([[0.0, 0.0, 1.0]])
        # Only the heave of a tilted body moves the point, by heave times tilt.
        assert np.hypot(*looks_at[0]) == pytest.approx(abs(heave) * math.hypot(roll, pitch), rel=0.02)
        down = mount.rotation @ (0.0, 0.0, 1.0)
        assert math.acos(-down[2]) == pytest.approx(math.hypot(roll, pitch), rel=1e-3)


def test_a_body_that_rises_lifts_the_camera_and_one_that_pitches_down_takes_it_down() -> None:
    mount, pitch = CameraMount(xyz=(0.2, -0.1, 0.13)), math.radians(2.0)
    risen, pitched = apply_body_motion(mount, 0.004, 0.0, 0.0), apply_body_motion(mount, 0.0, 0.0, pitch)
    np.testing.assert_allclose(risen.xyz, (0.2, -0.1, 0.134))
    np.testing.assert_allclose(risen.rotation, mount.rotation, atol=1e-12)
    assert pitched.xyz[2] == pytest.approx(0.13 * math.cos(pitch) - 0.2 * math.sin(pitch))


TIMES = np.arange(0.0, 40.0, 0.01).tolist()


def swaying(time: float) -> tuple[float, float]:
    return 0.02 * np.sin(time), -0.01 * np.cos(0.7 * time)


def errors_of(errors: TiltErrors, seed: int) -> np.ndarray:
    readings = simulate_tilt(swaying, TIMES, errors, np.random.default_rng(seed))
    return np.array([(r.roll, r.pitch) for r in readings]) - [swaying(time) for time in TIMES]


def test_an_ideal_unit_measures_the_true_tilt() -> None:
    np.testing.assert_allclose(errors_of(TiltErrors(0.0, 0.0), 1), 0.0, atol=1e-15)


@pytest.mark.newest_set_only
def test_noise_is_new_each_time_and_the_bias_stays() -> None:
    errors = errors_of(TiltErrors(bias=0.01, noise=0.002), 1)
    np.testing.assert_allclose(errors.std(axis=0), 0.002, rtol=0.05)
    assert abs(np.corrcoef(errors[:-1, 0], errors[1:, 0])[0, 1]) < 0.05
    biases = np.array([errors_of(TiltErrors(0.01, 0.002), seed).mean(axis=0) for seed in range(60)])
    assert biases.std() == pytest.approx(0.01, rel=0.25)
