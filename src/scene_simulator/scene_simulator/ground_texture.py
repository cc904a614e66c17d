"""The mottling of a floor's ground: faint, aperiodic enough, and fixed to the floor."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

_TILE = 1024
_SPACING = 0.00035
"""Distance of the texture's samples on the floor [m]; the tile repeats after 0.36 m, four views."""


@dataclass(frozen=True)
class GroundTexture:
    """Brightness of the ground relative to its mean.

    Attributes:
        tile: shape (1025, 1025), one period and its first row and column again.
    """

    tile: NDArray[np.float32]

    def sample(self, points: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return the relative brightness at floor points.

        Args:
            points: shape (height, width, 2), in the map frame [m].

        Returns:
            array, shape (height, width), about 1.
        """
        places = np.mod(points / _SPACING, _TILE).astype(np.float32)
        return np.asarray(cv2.remap(self.tile, places[..., 0], places[..., 1], cv2.INTER_LINEAR))


def mottled_ground(deviation: float, seed: int) -> GroundTexture:
    """Return a ground of grain and faint clouds.

    Args:
        deviation: standard deviation of the relative brightness.
        seed: the same seed gives the same ground.
    """
    white = np.fft.rfft2(np.random.default_rng(seed).normal(size=(_TILE, _TILE)))
    frequencies = np.hypot(np.fft.fftfreq(_TILE)[:, None], np.fft.rfftfreq(_TILE)[None, :]) / _SPACING
    grain, clouds = (np.exp(-0.5 * (frequencies * size * np.pi) ** 2) for size in (0.0006, 0.012))
    tile = np.fft.irfft2(white * (grain + 12.0 * clouds), s=(_TILE, _TILE))
    tile *= deviation / tile.std()
    return GroundTexture(np.pad(1.0 + tile, (0, 1), mode='wrap').astype(np.float32))
