"""A stereo rig, taught points, and their measurements from displaced poses."""

import math

import numpy as np

from shirube_core.geometry import CameraMount, PinholeCamera
from stereo_landmark.core.place.joint_fit import reproject
from stereo_landmark.core.place.place_locator import PlaceLocator
from stereo_landmark.core.stereo import SpatialPoints, StereoPoints, StereoRig

CAMERA = PinholeCamera(752, 480, 700.0, 700.0, 375.5, 239.5)
MOUNT = CameraMount((0.2, 0.1, 0.6), (-math.pi / 2.0, 0.0, -math.pi / 2.0))
RIG = StereoRig(CAMERA, CAMERA, 0.2, MOUNT)


def panel(distance=3.0, width=0.8, count=16, depth=0.1, seed=1):
    """Return points on a wall ahead, in the taught base frame, shape (n, 3) [m]."""
    rng = np.random.default_rng(seed)
    x = distance + depth * rng.uniform(-1.0, 1.0, count)
    y = width * rng.uniform(-0.5, 0.5, count)
    return np.column_stack([x, y, 0.6 + 0.5 * width * rng.uniform(-0.5, 0.5, count)])


def view(points, state, noise=0.0, rng=None, rig=RIG):
    """Return the measurements of points from a state."""
    pixels = reproject(state, points, rig).pixels
    if noise:
        pixels = pixels + noise * rng.normal(size=pixels.shape)
    sigma = max(noise, 1e-6)
    names = tuple(f'point {i}' for i in range(len(points)))
    return StereoPoints(names, pixels, np.tile(sigma**2 * np.eye(4), (len(points), 1, 1)))


def teach(points, noise=0.0, rng=None, rig=RIG) -> SpatialPoints:
    """Return the points as they are taught from the origin."""
    return PlaceLocator(rig).spatial_points(view(points, np.zeros(6), noise, rng, rig))


def random_state(rng, reach=0.4, turn=0.2):
    """Return a random state near the taught pose, shape (6,)."""
    x, y, yaw, height = *rng.uniform(-reach, reach, 2), rng.uniform(-turn, turn), rng.uniform(-0.01, 0.01)
    return np.array([x, y, height, yaw, 0.0, 0.0])


def errors_of(pose, height, state):
    """Return the errors of x, y, z [m] and yaw [rad]."""
    return np.array([pose.x, pose.y, height, pose.yaw]) - state[:4]
