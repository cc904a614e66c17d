"""A camera that looks up at lamps on a ceiling, with a global or a rolling shutter."""

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from scene_simulator.ceiling.lamp_light import LampLight, LampProjection, image_motion
from scene_simulator.ceiling.lamp_profile import face_homographies
from scene_simulator.ceiling.lens import CeilingLens
from scene_simulator.ceiling.room import CeilingRoom, CeilingSurface, occlude
from scene_simulator.imaging.exposure import CameraMotion, CameraPose, PoseAt, Shutter
from scene_simulator.imaging.sensors import GainSensor
from shirube_core.geometry import CameraMount, PinholeCamera

PAPER_OPTICS = PinholeCamera(1280, 1024, 636.4, 636.4, 639.5, 511.5)
"""The paper's camera (3.1): 1280 x 1024 pixels of 5.5 um behind 3.5 mm."""

UPWARD_MOUNT = CameraMount((0.0, 0.0, 0.0), (0.0, 0.0, math.pi / 2.0))
"""Straight up with the image's upper edge ahead; what is left of the robot is right in the image.

The paper counts heights from the camera: its lamps hang 2.5 m above this mount.
"""

_MAX_CEILING_MOTION = 2.0
"""Smear of the ceiling between two instants of an exposure [px]; its texture has nothing finer."""


@dataclass(frozen=True)
class CeilingPhoto:
    """A photograph and the truth about it.

    Attributes:
        image: shape (height, width), grey levels.
        stamp: when the first row starts to collect light, see ``Shutter`` [s].
        middle: middle of the frame's exposure [s].
        pose: ``T_map_camera`` at the middle.
        lamp_projections: true projections of the lamps whose centres are in the image.
    """

    image: NDArray[np.uint8]
    stamp: float
    middle: float
    pose: CameraPose
    lamp_projections: tuple[LampProjection, ...]


@dataclass(frozen=True)
class CeilingCamera:
    """A camera on the robot that looks up.

    Attributes:
        intrinsics: pinhole and distortion.
        shutter: when rows are exposed.
        lens: vignetting and blooming.
        sensor: gain, noise and saturation.
    """

    intrinsics: PinholeCamera = PAPER_OPTICS
    shutter: Shutter = field(default_factory=Shutter)
    lens: CeilingLens = field(default_factory=CeilingLens)
    sensor: GainSensor = field(default_factory=GainSensor)

    def photograph(
        self, room: CeilingRoom, pose_at: PoseAt, stamp: float, rng: np.random.Generator | None = None
    ) -> CeilingPhoto:
        """Take a picture.

        Args:
            room: ceiling and lights.
            pose_at: gives ``T_map_camera`` at a time [s].
            stamp: when the first row starts to collect light [s].
            rng: source of the sensor's noise, none for a picture without.
        """
        motion = self._motion(pose_at, stamp)
        light, lamp_projections = self._expose(room, motion, stamp)
        image = self.sensor.expose(light, rng)
        middle = self.shutter.frame_middle(stamp, self.intrinsics.height)
        return CeilingPhoto(image, stamp, middle, pose_at(middle), tuple(filter(self._is_inside, lamp_projections)))

    def light(self, room: CeilingRoom, pose_at: PoseAt, stamp: float) -> NDArray[np.float32]:
        """Return the light that the pixels of a frame collect, shape (height, width), before the sensor, 1 fills."""
        return self._expose(room, self._motion(pose_at, stamp), stamp)[0]

    def brightness_for(self, level: float) -> float:
        """Return the brightness [1/s] of a lamp that is imaged at a level above black, 1 is 255; more overexposes."""
        return level / (self.shutter.exposure * self.sensor.gain)

    def _expose(
        self, room: CeilingRoom, motion: CameraMotion, stamp: float
    ) -> tuple[NDArray[np.float32], list[LampProjection]]:
        """Return the light of a frame and where the lamps are."""
        light = np.zeros((self.intrinsics.height, self.intrinsics.width), dtype=np.float32)
        if room.surface is not None and room.surface.ambient > 0.0:
            self._add_surface(light, room.surface, motion, stamp)
        lamps = LampLight(self.intrinsics, self.shutter, self.lens, self._rays, motion, stamp)
        projections = [lamps.add_lamp(light, index, lamp) for index, lamp in enumerate(room.lamps)]
        middle = self.shutter.frame_middle(stamp, self.intrinsics.height)
        pose = motion.pose(middle)
        for person in room.people:
            place = np.array([*person.position_at(middle), person.height]) - pose.position
            occlude(light, self._rays, pose.rotation, (place[0], place[1], place[2], person.radius))
        light *= self._transmission
        return light, [projection for projection in projections if projection is not None]

    def _add_surface(
        self, light: NDArray[np.float32], surface: CeilingSurface, motion: CameraMotion, stamp: float
    ) -> None:
        """Add the light of the ceiling, smeared by the motion in the exposure."""
        exposure, height = self.shutter.exposure, self.intrinsics.height
        middle = self.shutter.frame_middle(stamp, height)
        before, now, after = (motion.pose(middle + fraction * exposure) for fraction in (-0.5, 0.0, 0.5))
        ahead = now.position + now.rotation[:, 2] * (surface.height - now.position[2])
        count = max(1, math.ceil(image_motion(ahead, self.intrinsics, before, after) / _MAX_CEILING_MOTION))
        times = self.shutter.exposure_boundaries(stamp, slice(0, height), count)
        starts, stops = times[:, :-1], times[:, 1:]
        poses = motion.poses(0.5 * (starts + stops).ravel())
        homographies = face_homographies((0.0, 0.0, surface.height), np.eye(3), *poses)
        levels = exposure / count * surface.mean_levels(starts, stops)
        surface.add_light(light, self._rays, homographies.reshape(height, count, 3, 3), levels)

    def _motion(self, pose_at: PoseAt, stamp: float) -> CameraMotion:
        """Return the camera trajectory from the start of the first row's exposure to the end of the last row's."""
        return CameraMotion(pose_at, stamp, self.shutter.frame_end(stamp, self.intrinsics.height))

    def _is_inside(self, projection: LampProjection) -> bool:
        u, v = projection.centre
        return -0.5 < u < self.intrinsics.width - 0.5 and -0.5 < v < self.intrinsics.height - 0.5

    @cached_property
    def _rays(self) -> NDArray[np.float64]:
        """Rays of all pixels and of a border of one pixel, shape (height + 2, width + 2, 2), z = 1."""
        v, u = np.mgrid[-1 : self.intrinsics.height + 1, -1 : self.intrinsics.width + 1]
        rays = self.intrinsics.rays_from_pixels(np.column_stack([u.ravel(), v.ravel()]))
        return np.ascontiguousarray(rays[:, :2]).reshape(*u.shape, 2)

    @cached_property
    def _transmission(self) -> NDArray[np.float32]:
        """Fraction of the light that passes the lens, shape (height, width)."""
        return self.lens.transmission(self.intrinsics)
