"""A room as a camera sees it that looks up: its lights, and the ceiling of lit panels between them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import cv2
import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scene_simulator.ceiling.lamp import CeilingLamp
from scene_simulator.errors import SceneError, check_seed
from shirube_core.waveform import Waveform, steady_light


@dataclass(frozen=True)
class Person:
    """A person who walks to and fro between two places.

    Attributes:
        start: x, y at time 0 in the map frame [m].
        end: x, y where the person turns round [m].
        height: z of the top of the head in the map frame [m].
        speed: walking speed, 0 for a person who stands at the start [m/s].
        radius: half the width of the shoulders [m].
    """

    start: tuple[float, float]
    end: tuple[float, float]
    height: float
    speed: float = 1.2
    radius: float = 0.22

    def __post_init__(self) -> None:
        """Refuse sizes and speeds that are not positive with a SceneError."""
        if not (0.0 < self.radius < math.inf and 0.0 <= self.speed < math.inf):
            raise SceneError(f'a person has radius {self.radius} m and speed {self.speed} m/s: give positive ones')

    def position_at(self, time: float) -> tuple[float, float]:
        """Return x, y at a time [s] in the map frame [m]."""
        length = math.dist(self.start, self.end)
        phase = self.speed * time / length % 2.0 if length > 0.0 else 0.0
        share = min(phase, 2.0 - phase)
        x, y = (a + share * (b - a) for a, b in zip(self.start, self.end, strict=True))
        return x, y


@njit(cache=True)
def occlude(
    light: NDArray[np.float32],
    rays: NDArray[np.float64],
    R_map_camera: NDArray[np.float64],
    cylinder: tuple[float, float, float, float],
) -> None:
    """Remove the light behind a person from a picture.

    Args:
        light: shape (height, width), changed in place.
        rays: shape (height + 2, width + 2, 2), rays of the pixels and of a border of one pixel, z = 1.
        R_map_camera: shape (3, 3).
        cylinder: x, y and top of the person relative to the camera, in the axes of the map, and radius [m].
    """
    px, py, top, radius = cylinder
    r = R_map_camera
    for row in range(light.shape[0]):
        for column in range(light.shape[1]):
            u, v = rays[row + 1, column + 1]
            dx = r[0, 0] * u + r[0, 1] * v + r[0, 2]
            dy = r[1, 0] * u + r[1, 1] * v + r[1, 2]
            dz = r[2, 0] * u + r[2, 1] * v + r[2, 2]
            if dz <= 0.0 or top <= 0.0:
                continue
            # The point of the ray below the top that is nearest to the axis.
            nearest = (px * dx + py * dy) / max(dx * dx + dy * dy, 1e-12)
            s = min(max(nearest, 0.0), top / dz)
            if (s * dx - px) ** 2 + (s * dy - py) ** 2 < radius * radius:
                light[row, column] = 0.0


_TILE = 1024
_SPACING = 0.0046875  # distance of the texture's samples [m]: the tile repeats after 4.8 m, eight panels
_PANEL = 128  # width of a ceiling panel [samples]: 0.6 m


@dataclass(frozen=True, eq=False)
class CeilingSurface:
    """A textured plane above the robot.

    Attributes:
        height: z in the map frame [m].
        ambient: what the ceiling of mean brightness collects in a pixel, in full wells per second of
            exposure [1/s].
        tile: shape (1024, 1024), brightness relative to the mean, repeated along x and y.
        flicker: how the light that falls on it changes, one part.
    """

    height: float
    ambient: float
    tile: NDArray[np.float32]
    flicker: Waveform = field(default_factory=steady_light)

    def mean_levels(self, starts: ArrayLike, stops: ArrayLike) -> NDArray[np.float64]:
        """Return the mean light of the ceiling over windows of time [s], an array of the same shape [1/s]."""
        return np.asarray(self.ambient * self.flicker.mean_levels(starts, stops)[..., 0])

    def add_light(
        self,
        light: NDArray[np.float32],
        rays: NDArray[np.float64],
        homographies: NDArray[np.float64],
        levels: NDArray[np.float64],
    ) -> None:
        """Add the ceiling's light to a picture.

        Args:
            light: shape (height, width), in full wells, changed in place.
            rays: shape (height + 2, width + 2, 2), rays of the pixels and of a border of one pixel, z = 1.
            homographies: shape (height, instants, 3, 3), from ``face_homographies`` for the ceiling.
            levels: shape (height, instants), what the ceiling of mean brightness gives each row, in full wells.
        """
        per_sample = homographies / np.array([_SPACING, _SPACING, 1.0])[:, None]
        _add(light, rays, per_sample, self.tile, levels)


def panelled_ceiling(
    height: float, ambient: float, contrast: float, seed: int, flicker: Waveform | None = None
) -> CeilingSurface:
    """Return a ceiling of panels with dark joints and faint stains.

    Args:
        height: z in the map frame [m].
        ambient: mean light, in full wells per second of exposure [1/s].
        contrast: standard deviation of the stains and half the depth of the joints, relative to the mean.
        seed: the same seed gives the same ceiling.
        flicker: how the light changes, steady by default.

    Raises:
        SceneError: negative seed, or light or contrast outside their range.
    """
    check_seed(seed)
    if not (0.0 <= ambient < float('inf') and 0.0 <= contrast <= 0.25):
        raise SceneError(f'the ceiling has light {ambient} and contrast {contrast}: give 0 or more, 0 to 0.25')
    noise = np.random.default_rng(seed).standard_normal((_TILE, _TILE)).astype(np.float32)
    stains = cv2.GaussianBlur(np.tile(noise, (2, 2)), (0, 0), 6.0)[_TILE // 2 :, _TILE // 2 :][:_TILE, :_TILE]
    tile = 1.0 + contrast * stains / stains.std()
    for joint in (slice(0, None, _PANEL), slice(1, None, _PANEL)):
        tile[joint] -= 2.0 * contrast
        tile[:, joint] -= 2.0 * contrast
    shades = np.maximum(tile, 0.0).astype(np.float32)
    return CeilingSurface(height, ambient, shades, flicker or steady_light())


@njit(cache=True)
def _add(
    light: NDArray[np.float32],
    rays: NDArray[np.float64],
    homographies: NDArray[np.float64],
    tile: NDArray[np.float32],
    levels: NDArray[np.float64],
) -> None:
    height, width = light.shape
    mask = tile.shape[0] - 1
    for row in range(height):
        for instant in range(homographies.shape[1]):
            h, level = homographies[row, instant], levels[row, instant]
            for column in range(width):
                x, y = rays[row + 1, column + 1]
                w = h[2, 0] * x + h[2, 1] * y + h[2, 2]
                if w <= 1e-9:
                    continue
                scale = 1.0 / w
                s = (h[0, 0] * x + h[0, 1] * y + h[0, 2]) * scale
                t = (h[1, 0] * x + h[1, 1] * y + h[1, 2]) * scale
                i, j = int(np.floor(t)), int(np.floor(s))
                a, b = t - i, s - j
                i0, j0, i1, j1 = i & mask, j & mask, (i + 1) & mask, (j + 1) & mask
                upper = tile[i0, j0] + b * (tile[i0, j1] - tile[i0, j0])
                lower = tile[i1, j0] + b * (tile[i1, j1] - tile[i1, j0])
                light[row, column] += level * (upper + a * (lower - upper))


@dataclass(frozen=True)
class CeilingRoom:
    """The lights, coded or not, the ceiling (none is black), and people under it."""

    lamps: tuple[CeilingLamp, ...] = ()
    surface: CeilingSurface | None = None
    people: tuple[Person, ...] = ()

    def with_lights(self, lights: Sequence[CeilingLamp]) -> CeilingRoom:
        """Return the room with more lights, counted after the others."""
        return replace(self, lamps=(*self.lamps, *lights))

    def with_ambient_light(
        self, ambient: float, contrast: float = 0.1, seed: int = 0, flicker: Waveform | None = None
    ) -> CeilingRoom:
        """Return the room with its ceiling in the light: panels just above the first lamp.

        Arguments as for ``panelled_ceiling``; a SceneError if the room has no lamp.
        """
        if not self.lamps:
            raise SceneError('a room without a lamp has no height: make its ceiling with panelled_ceiling')
        # 2 cm above, so that the lamps' faces are never in its plane.
        height = self.lamps[0].xyz[2] + 0.02
        return replace(self, surface=panelled_ceiling(height, ambient, contrast, seed, flicker))
