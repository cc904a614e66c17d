"""A wall with discs and rectangles, seen by a stereo pair: every pixel is the mean of a grid of rays."""

from dataclasses import dataclass, replace

import numpy as np
from place_scenes import RIG

from shirube_geometry import matrix_from_rpy
from stereo_landmark.core.procedure.detected_scene import ImageProcessing, detect_scene
from stereo_landmark.core.procedure.stereo_view import StereoView

FINE = 4
"""Rays along each side of a pixel."""
GOLDEN = 0.6180339887


@dataclass(frozen=True)
class Disc:
    """A round thing at y (left) and z (up) of the wall [m]."""

    y: float
    z: float
    radius: float
    level: float

    def covers(self, y, z):
        return (y - self.y) ** 2 + (z - self.z) ** 2 <= self.radius**2


@dataclass(frozen=True)
class Plate:
    """A rectangle on the wall, its middle at y and z [m]."""

    y: float
    z: float
    width: float
    height: float
    level: float

    def covers(self, y, z):
        return (np.abs(y - self.y) <= 0.5 * self.width) & (np.abs(z - self.z) <= 0.5 * self.height)


@dataclass(frozen=True)
class Wall:
    """Things on a wall at x = distance; later ones are before earlier ones."""

    things: tuple
    distance: float = 3.0
    level: float = 150.0

    def without(self, *numbers):
        return replace(self, things=tuple(t for i, t in enumerate(self.things) if i not in numbers))


def look(wall, state, rig=RIG, noise=1.0, seed=1):
    """Return both images of the wall from x, y, z, yaw (and tilt) of the robot."""
    rng = np.random.default_rng(seed)
    R_place_base = matrix_from_rpy((0.0, 0.0, state[3])) @ matrix_from_rpy((*state[4:6], 0.0))
    images = []
    for camera, shift in ((rig.left, 0.0), (rig.right, rig.baseline)):
        u = (np.arange(camera.width * FINE) + 0.5) / FINE - 0.5
        v = (np.arange(camera.height * FINE) + 0.5)[:, None] / FINE - 0.5
        # A straight grid would move upright edges by up to an eighth of a pixel.
        u = u + ((GOLDEN * np.arange(camera.height * FINE)) % 1.0 - 0.5)[:, None] / FINE
        v = v + ((GOLDEN * np.arange(camera.width * FINE)) % 1.0 - 0.5) / FINE
        rays = np.stack(
            np.broadcast_arrays((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0), -1
        )
        R = R_place_base @ rig.mount.rotation
        eye = state[:3] + R_place_base @ rig.mount.xyz + R @ [shift, 0.0, 0.0]
        ahead = rays @ R[0]
        reach = (wall.distance - eye[0]) / ahead
        y, z = eye[1] + reach * (rays @ R[1]), eye[2] + reach * (rays @ R[2])
        picture = np.full(y.shape, wall.level)
        for thing in wall.things:
            picture[thing.covers(y, z)] = thing.level
        picture = picture.reshape(camera.height, FINE, camera.width, FINE).mean(axis=(1, 3))
        images.append(
            np.clip(np.rint(picture + noise * rng.normal(size=picture.shape)), 0, 255).astype(np.uint8)
        )
    return images


def view_of(wall, state, kinds, noise=1.0, seed=1, processing=None):
    """Return what both cameras detect of a wall."""
    processing = processing or ImageProcessing()
    left, right = (
        detect_scene(image, processing, kinds) for image in look(wall, np.asarray(state), RIG, noise, seed)
    )
    return StereoView(left, right, RIG)
