import numpy as np
import pytest
from lamp_room import BEACONS, MOUNT

from shirube_core.geometry import gravity_aligned_camera, matrix_from_rpy
from vlc_beacon.core.pose.pose_least_squares import camera_points

LAMPS, STILL = np.array([beacon.xyz for beacon in BEACONS]), np.zeros((4, 3))
TILTED = gravity_aligned_camera(MOUNT, 0.03, -0.02)
STATE = np.array([0.7, -0.2, 0.1, 0.9, 0.0, 0.0])


def test_a_lamp_appears_where_the_chain_of_frames_takes_it():
    R_map_base = matrix_from_rpy((0.03, -0.02, 0.9))
    place = STATE[:3] + R_map_base @ np.array(MOUNT.xyz)
    expected = (LAMPS - place) @ R_map_base @ MOUNT.rotation
    assert camera_points(STATE, LAMPS, STILL, TILTED) == pytest.approx(expected, abs=1e-12)


def test_a_motion_is_seen_as_from_the_pose_after_it():
    cos, sin = np.cos(0.9), np.sin(0.9)
    after = STATE + np.array([cos * 0.2 - sin * 0.1, sin * 0.2 + cos * 0.1, 0.0, 0.4, 0.0, 0.0])
    moved = camera_points(STATE, LAMPS, np.tile([0.2, 0.1, 0.4], (4, 1)), TILTED)
    assert moved == pytest.approx(camera_points(after, LAMPS, STILL, TILTED), abs=1e-12)


def test_the_tilt_is_that_of_the_robot():
    level, tilted = np.array([0.7, -0.2, 0.1, 0.0, 0.0, 0.0]), np.array([0.7, -0.2, 0.1, 0.0, 0.03, -0.02])
    points = camera_points(tilted, LAMPS, STILL, gravity_aligned_camera(MOUNT))
    assert points == pytest.approx(camera_points(level, LAMPS, STILL, TILTED), abs=1e-12)
