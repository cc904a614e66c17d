"""A camera under a robot's belly that photographs a floor."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from scene_simulator.errors import SceneError
from scene_simulator.floor.dot_floor import DotFloor
from scene_simulator.floor.view import FloorView
from scene_simulator.imaging.sensors import Lighting, Sensor
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

_TILE = 1024
_SPACING = 0.00035  # distance of the texture's samples on the floor [m]; the tile repeats after 0.36 m, four views
PAPER_CAMERA = PinholeCamera(235, 235, 339.44, 339.44, 117.0, 117.0)
"""The paper's camera (3.1): 90 mm square in 235 pixels square from 130 mm."""

DOWNWARD_MOUNT = CameraMount()


@dataclass(frozen=True)
class GroundTexture:
    """Brightness of the ground relative to its mean: one period and its first row and column again, (1025, 1025)."""

    tile: NDArray[np.float32]

    def sample(self, points: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return the relative brightness, about 1, at floor points, shape (height, width, 2) [m]."""
        places = np.mod(points / _SPACING, _TILE).astype(np.float32)
        return np.asarray(cv2.remap(self.tile, places[..., 0], places[..., 1], cv2.INTER_LINEAR))


def mottled_ground(deviation: float, seed: int) -> GroundTexture:
    """Return a ground of grain and faint clouds with a standard deviation of the relative brightness, and a seed."""
    white = np.fft.rfft2(np.random.default_rng(seed).normal(size=(_TILE, _TILE)))
    frequencies = np.hypot(np.fft.fftfreq(_TILE)[:, None], np.fft.rfftfreq(_TILE)[None, :]) / _SPACING
    grain, clouds = (np.exp(-0.5 * (frequencies * size * np.pi) ** 2) for size in (0.0006, 0.012))
    tile = np.fft.irfft2(white * (grain + 12.0 * clouds), s=(_TILE, _TILE))
    tile *= deviation / tile.std()
    return GroundTexture(np.pad(1.0 + tile, (0, 1), mode='wrap').astype(np.float32))


class Disturbance(Protocol):
    """Something between the clean floor and the picture."""

    def apply_to(self, view: FloorView) -> None:
        """Apply the disturbance to the view."""


@dataclass(frozen=True)
class FloorPhoto:
    """A picture, (h, w) or (h, w, 3) BGR uint8, and the fraction of each pixel that dirt hides, (h, w)."""

    image: NDArray[np.uint8]
    dirt: NDArray[np.float32]

    @property
    def dirt_fraction(self) -> float:
        """Fraction of the whole view in which dirt hides the floor."""
        return float(self.dirt.mean())


@dataclass(frozen=True)
class FloorCamera:
    """A belly camera.

    Attributes:
        intrinsics: pinhole and distortion.
        lighting: lamps and lens.
        sensor: noise and saturation.
        colour: whether it takes blue-green-red images.
    """

    intrinsics: PinholeCamera = PAPER_CAMERA
    lighting: Lighting = field(default_factory=Lighting)
    sensor: Sensor = field(default_factory=Sensor)
    colour: bool = False

    def photograph(
        self,
        floor: DotFloor,
        poses: Sequence[SE2],
        mount: CameraMount = DOWNWARD_MOUNT,
        disturbances: Sequence[Disturbance] = (),
        rng: np.random.Generator | None = None,
    ) -> FloorPhoto:
        """Take a picture of the floor.

        Args:
            floor: the floor.
            poses: ``T_map_base`` at evenly spaced instants of the exposure; one for a robot at rest.
            mount: pose of the camera in the frame of the poses.
            disturbances: dirt, objects and light on the floor, bottom first.
            rng: source of the sensor's noise, none for a picture without.

        Returns:
            the picture; its truth is the pose at the middle of the exposure.

        Raises:
            SceneError: no pose was given.
        """
        if not poses:
            raise SceneError('an exposure needs at least one pose')
        view = FloorView(self.intrinsics, mount, poses, self._rays, colour=self.colour)
        ground = _cached_ground(floor.design.mottling, floor.seed).sample(view.floor_points)
        view.layers[:] = ground[..., None] * view.channels([floor.design.ground]).astype(np.float32)
        view.paint(floor.chips, dirt=False)
        for disturbance in disturbances:
            disturbance.apply_to(view)
        light = view.layers.mean(axis=0) * self._white[..., None] + view.glare[..., None]
        image = self.sensor.expose(self.lighting.spread(light), rng)
        return FloorPhoto(image if self.colour else image[..., 0], view.covered.mean(axis=0))

    def project(
        self, points: NDArray[np.float64], pose: SE2, mount: CameraMount = DOWNWARD_MOUNT
    ) -> NDArray[np.float64]:
        """Return the pixels u, v of points of the floor, shape (n, 2) [px], also outside the image.

        Args:
            points: shape (n, 2), in the map frame [m].
            pose: ``T_map_base``.
            mount: pose of the camera in the base frame.
        """
        points_base = pose.inverse().transform(points)
        return self.intrinsics.pixels_from_points(mount.camera_points_from_floor(points_base))

    def visible_chips(
        self, floor: DotFloor, pose: SE2, mount: CameraMount = DOWNWARD_MOUNT
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the chips whose centres are in the image from a pose of the robot, ``T_map_base``.

        Returns:
            their indices, shape (n,), and the true pixels of their centres, shape (n, 2) [px].
        """
        view = FloorView(self.intrinsics, mount, [pose], self._rays, colour=False)
        near = floor.chips.near(view.centre, view.reach)
        pixels = self.project(floor.points[near], pose, mount)
        size = (self.intrinsics.width - 0.5, self.intrinsics.height - 0.5)
        inside = ((pixels > -0.5) & (pixels < size)).all(axis=1)
        return near[inside], pixels[inside]

    @cached_property
    def _rays(self) -> NDArray[np.float64]:
        """Rays of all pixels, row by row, shape (height * width, 3)."""
        v, u = np.mgrid[: self.intrinsics.height, : self.intrinsics.width]
        return self.intrinsics.rays_from_pixels(np.column_stack([u.ravel(), v.ravel()]))

    @cached_property
    def _white(self) -> NDArray[np.float32]:
        """Brightness of a white floor, shape (height, width)."""
        return self.lighting.field(self.intrinsics)


@lru_cache(maxsize=4)
def _cached_ground(mottling: float, seed: int) -> GroundTexture:
    """Return the ground of a floor; making it takes longer than a picture."""
    return mottled_ground(mottling, seed)
