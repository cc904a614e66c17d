"""A sensor with adjustable gain, quick on large dark images."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numba import njit
from numpy.typing import NDArray

_POOL = 1 << 21
"""Normal random numbers drawn once; each row of each frame reads them from a random start."""


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
            pool, starts, read_noise = (
                np.zeros(width, dtype=np.float32),
                np.zeros(height, dtype=np.int64),
                0.0,
            )
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
