"""From the light of a scene to grey levels: lamps and lens, then the sensor."""

import math
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from shirube_core.geometry import PinholeCamera


@njit(cache=True, error_model='numpy')
def clip_integral(t: float) -> float:
    """Return the integral of clip(s, 0, 1) over s from 0 to t."""
    if t <= 0.0:
        return 0.0
    return 0.5 * t * t if t < 1.0 else t - 0.5


_POOL = 1 << 21  # normal random numbers drawn once; each row of each frame reads them from a random start


@dataclass(frozen=True)
class Lighting:
    """Illumination by the camera's lamps, and lens losses.

    Attributes:
        level: grey level of a white floor in the middle of the image, 1 saturates.
        gradient: relative change from the middle to the right and to the lower edge.
        vignetting: relative loss in the corners.
        blur: standard deviation of the lens's point-spread function [px].
    """

    level: float = 0.9
    gradient: tuple[float, float] = (0.12, -0.08)
    vignetting: float = 0.3
    blur: float = 0.6

    def field(self, camera: PinholeCamera) -> NDArray[np.float32]:
        """Return the brightness of a white floor over the image, shape (height, width)."""
        u = np.linspace(-1.0, 1.0, camera.width)[None, :]
        v = np.linspace(-1.0, 1.0, camera.height)[:, None]
        slope = 1.0 + self.gradient[0] * u + self.gradient[1] * v
        return np.asarray(self.level * slope * (1.0 - self.vignetting * (u**2 + v**2) / 2.0), dtype=np.float32)

    def spread(self, light: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return an image, shape (height, width, channels), as the lens blurs it."""
        if self.blur == 0.0:
            return light
        blurred = cv2.GaussianBlur(light, (0, 0), self.blur, borderType=cv2.BORDER_REPLICATE)
        return np.asarray(blurred, dtype=np.float32).reshape(light.shape)


@dataclass(frozen=True)
class Sensor:
    """Counts electrons: number at saturation, whose arrival is the shot noise, and read-out noise [electrons]."""

    full_well: float = 9000.0
    read_noise: float = 12.0

    def expose(self, light: NDArray[np.float32], rng: np.random.Generator | None) -> NDArray[np.uint8]:
        """Return 8-bit grey levels.

        Args:
            light: any shape, 1 saturates.
            rng: source of the noise, none for an ideal sensor.

        Returns:
            array of the same shape.
        """
        levels = light
        if rng is not None:
            electrons = np.maximum(light, 0.0) * self.full_well
            noise = rng.standard_normal(light.shape, dtype=np.float32)
            levels = light + noise * np.sqrt(electrons + self.read_noise**2) / self.full_well
        return np.clip(np.rint(255.0 * levels), 0.0, 255.0).astype(np.uint8)


@dataclass(frozen=True)
class GainSensor:
    """A sensor that counts electrons and reads them out as 8-bit grey levels.

    Attributes:
        full_well: electrons at which a pixel overflows; their random arrival is the shot noise.
        read_noise: standard deviation of the read-out before the gain [electrons].
        gain: grey level 255 equals ``full_well / gain`` electrons.
        black_level: grey level of darkness, 255 is 1.
    """

    full_well: float = 9000.0
    read_noise: float = 12.0
    gain: float = 1.0
    black_level: float = 4.0 / 255.0

    def expose(self, light: NDArray[np.float32], rng: np.random.Generator | None) -> NDArray[np.uint8]:
        """Return grey levels, saturated at 255.

        Args:
            light: shape (height, width), collected light, 1 fills the well.
            rng: source of the noise, none for an ideal sensor.

        Returns:
            array of the same shape.
        """
        height, width = light.shape
        image = np.empty(light.shape, dtype=np.uint8)
        if rng is None:
            pool, starts, read_noise = (np.zeros(width, dtype=np.float32), np.zeros(height, dtype=np.int64), 0.0)
        else:
            pool, read_noise = _normal_numbers(), self.read_noise
            starts = rng.integers(0, _POOL - width, height)
        _read_out(image, light, pool, starts, (self.full_well, read_noise, self.gain, self.black_level))
        return image


@lru_cache(maxsize=1)
def _normal_numbers() -> NDArray[np.float32]:
    return np.random.default_rng(0).standard_normal(_POOL, dtype=np.float32)


@njit(cache=True)
def _read_out(
    image: NDArray[np.uint8],
    light: NDArray[np.float32],
    pool: NDArray[np.float32],
    starts: NDArray[np.int64],
    sensor: tuple[float, float, float, float],
) -> None:
    full_well, read_noise = np.float32(sensor[0]), np.float32(sensor[1])
    levels = np.float32(255.0 * sensor[2] / sensor[0])
    black = np.float32(255.0 * sensor[3] + 0.5)
    variance = read_noise * read_noise
    for row in range(image.shape[0]):
        start = starts[row]
        for column in range(image.shape[1]):
            electrons = min(max(light[row, column], np.float32(0.0)), np.float32(1.0)) * full_well
            electrons += pool[start + column] * math.sqrt(electrons + variance)
            image[row, column] = int(min(max(electrons * levels + black, np.float32(0.0)), np.float32(255.0)))
