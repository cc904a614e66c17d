import numpy as np
import pytest
from lamp_room import BEACONS, MOUNT

from shirube_core.geometry import gravity_aligned_camera, matrix_from_rpy
from vlc_beacon.core.pose.bearing_model import camera_points

LAMPS = np.array([beacon.xyz for beacon in BEACONS])


def test_a_lamp_appears_where_the_chain_of_frames_takes_it():
    state = np.array([0.7, -0.2, 0.1, 0.9, 0.0, 0.0])
    camera = gravity_aligned_camera(MOUNT, 0.03, -0.02)
    R_map_base = matrix_from_rpy((0.03, -0.02, 0.9))
    R_map_camera = R_map_base @ MOUNT.rotation
    place = state[:3] + R_map_base @ np.array(MOUNT.xyz)
    expected = (LAMPS - place) @ R_map_camera
    assert camera_points(state, LAMPS, np.zeros((4, 3)), camera) == pytest.approx(expected, abs=1e-12)


def test_a_motion_is_seen_as_from_the_pose_after_it():
    camera = gravity_aligned_camera(MOUNT, 0.03, -0.02)
    cos, sin = np.cos(0.9), np.sin(0.9)
    before = np.array([0.7, -0.2, 0.1, 0.9, 0.0, 0.0])
    after = np.array([0.7 + cos * 0.2 - sin * 0.1, -0.2 + sin * 0.2 + cos * 0.1, 0.1, 1.3, 0.0, 0.0])
    pose_derivatives = camera_points(before, LAMPS, np.tile([0.2, 0.1, 0.4], (4, 1)), camera)
    assert pose_derivatives == pytest.approx(camera_points(after, LAMPS, np.zeros((4, 3)), camera), abs=1e-12)


def test_the_tilt_is_that_of_the_robot():
    tilted = camera_points(
        np.array([0.7, -0.2, 0.1, 0.0, 0.02, -0.01]), LAMPS, np.zeros((4, 3)), gravity_aligned_camera(MOUNT)
    )
    known = camera_points(
        np.array([0.7, -0.2, 0.1, 0.0, 0.0, 0.0]),
        LAMPS,
        np.zeros((4, 3)),
        gravity_aligned_camera(MOUNT, 0.02, -0.01),
    )
    assert tilted == pytest.approx(known, abs=1e-12)
