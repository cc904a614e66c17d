"""The paper's room: four lamps at 2.5 m, and their projections in a camera on the floor."""

import math

import numpy as np

from shirube_core.geometry import SE2, CameraMount, PinholeCamera, gravity_aligned_camera
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.pose.pose_least_squares import camera_points

CAMERA = PinholeCamera(1280, 1024, 636.4, 636.4, 639.5, 511.5)
MOUNT = CameraMount((0.1, 0.05, 0.3), (0.0, 0.0, -math.pi / 2.0))
CORNERS = ((0.0, 0.0), (0.0, 1.8), (1.8, 0.0), (1.8, 1.8))
BEACONS = [Beacon(i + 1, (*xy, 2.8), 0.0325) for i, xy in enumerate(CORNERS)]
UNEVEN_PLACES = ((0.0, 0.0, 2.8), (0.1, 1.8, 2.5), (1.7, 0.2, 3.1), (1.9, 1.5, 2.7), (0.8, 0.9, 2.6))
UNEVEN = [Beacon(i + 1, xyz, 0.0325) for i, xyz in enumerate(UNEVEN_PLACES)]


def pixels_of(beacons, pose, height=0.0, tilt=(0.0, 0.0), motions=None, camera=CAMERA):
    """Return where the lamps appear, shape (n, 2) [px]."""
    state = np.array([pose.x, pose.y, height, pose.yaw, 0.0, 0.0])
    lamps = np.array([beacon.xyz for beacon in beacons])
    motions = np.zeros((len(lamps), 3)) if motions is None else motions
    return camera.pixels_from_points(camera_points(state, lamps, motions, gravity_aligned_camera(MOUNT, *tilt)))


def random_pose(rng):
    """Return a pose from which all lamps are in view."""
    return SE2(*rng.uniform([0.5, 0.5, -3.1], [1.3, 1.3, 3.1]))


def normalised_square(pose, covariance, truth):
    """Return the squared error of a pose over its covariance of x, y and perhaps yaw, divided by their number."""
    error = np.array([pose.x - truth.x, pose.y - truth.y, truth.yaw_to(pose)])[: len(covariance)]
    return error @ np.linalg.solve(covariance, error) / len(covariance)
