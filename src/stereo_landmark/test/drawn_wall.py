"""Renders a wall with discs and rectangles for a stereo pair, and teaches it; a pixel is the mean of some rays."""

from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from place_scenes import RIG

from shirube_core.geometry import matrix_from_rpy
from stereo_landmark.core.primitives.primitive import ImageProcessing, PrimitiveKind
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.teaching.primitive_selection import TargetSelection
from stereo_landmark.core.teaching.teacher import Teacher

FINE = 4
"""Rays along each side of a pixel."""
GOLDEN = 0.6180339887
"""A regular grid of rays would shift vertical edges by up to 1/8 px; a golden ratio lattice does not."""


@dataclass(frozen=True)
class Disc:
    """A disc at y (left) and z (up) of the wall [m]."""

    y: float
    z: float
    radius: float
    level: float

    @property
    def row(self):
        return self.y, self.z, self.radius, 0.0, self.level


@dataclass(frozen=True)
class Plate:
    """A rectangle on the wall, centred at y and z [m]."""

    y: float
    z: float
    width: float
    height: float
    level: float

    @property
    def row(self):
        return self.y, self.z, 0.5 * self.width, 0.5 * self.height, self.level


@dataclass(frozen=True)
class Wall:
    """Shapes on a wall at x = distance; later ones occlude earlier ones."""

    things: tuple
    distance: float = 3.0
    level: float = 150.0

    def without(self, *numbers):
        return replace(self, things=tuple(t for i, t in enumerate(self.things) if i not in numbers))


def look(wall, state, rig=RIG, noise=1.0, seed=1):
    """Return both images of the wall from a robot state x, y, z, yaw (and tilt)."""
    rng = np.random.default_rng(seed)
    R_place_base = matrix_from_rpy((0.0, 0.0, state[3])) @ matrix_from_rpy((*state[4:6], 0.0))
    R = R_place_base @ rig.mount.rotation
    things = np.array([thing.row for thing in wall.things])
    images = []
    for camera, shift in ((rig.left, 0.0), (rig.right, rig.baseline)):
        eye = state[:3] + R_place_base @ rig.mount.xyz + R @ [shift, 0.0, 0.0]
        picture = np.empty((camera.height, camera.width))
        shade(picture, camera.matrix, R, eye, wall.distance, wall.level, things)
        noisy = picture + noise * rng.normal(size=picture.shape)
        images.append(np.clip(np.rint(noisy), 0, 255).astype(np.uint8))
    return images


@njit(cache=True)
def shade(picture, K, R, eye, distance, level, things):
    """Render the image of a camera at ``eye``."""
    for row in range(picture.shape[0]):
        for column in range(picture.shape[1]):
            total = 0.0
            for k in range(FINE * FINE):
                u = column - 0.5 + (k + 0.5) / (FINE * FINE)
                v = row - 0.5 + (k * GOLDEN + 0.37 * column + 0.11 * row) % 1.0
                x, y = (u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1]
                reach = (distance - eye[0]) / (R[0, 0] * x + R[0, 1] * y + R[0, 2])
                left = eye[1] + reach * (R[1, 0] * x + R[1, 1] * y + R[1, 2])
                up = eye[2] + reach * (R[2, 0] * x + R[2, 1] * y + R[2, 2])
                seen = level
                for i in range(len(things)):
                    dy, dz = left - things[i, 0], up - things[i, 1]
                    if things[i, 3] == 0.0:
                        covers = dy * dy + dz * dz <= things[i, 2] ** 2
                    else:
                        covers = abs(dy) <= things[i, 2] and abs(dz) <= things[i, 3]
                    if covers:
                        seen = things[i, 4]
                total += seen
            picture[row, column] = total / (FINE * FINE)


def detect_view(images, rig=RIG):
    """Return the detections of both cameras."""
    return StereoView(*(detect_scene(image, ImageProcessing()) for image in images), rig)


def view_of(wall, state, noise=1.0, seed=1):
    """Return the detections of both cameras from a robot state."""
    return detect_view(look(wall, np.asarray(state), RIG, noise, seed))


def from_left(view, kind=PrimitiveKind.ELLIPSE):
    """Return the primitives of a kind in the left image, from left to right."""
    return sorted(view.left.kinds[kind].primitives, key=lambda each: each.centre[0])


def teach_view(view, parts, name='wall', T_map_place=None, target='target'):
    """Teach a place with one target from the detections of both cameras."""
    choice = TargetSelection(target, parts)
    return Teacher(view, ImageProcessing()).teach(name, [choice], T_map_place)
