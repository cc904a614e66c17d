"""The grain of walls and floors: stains, plaster and specks, averaged beforehand for distant views."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

SPACING = 0.004
"""Distance of the finest samples [m]: the tile repeats after 4.1 m."""

_SIZE = 1024
_LEVELS = 7


@dataclass(frozen=True, eq=False)
class TexturePyramid:
    """A tile at falling resolution: each level has half the samples of the one before.

    Attributes:
        samples: all levels one after the other, mean 0 and standard deviation 1 at the finest.
        starts: shape (levels,), where each level begins.
        sizes: shape (levels,), samples along each side.
    """

    samples: NDArray[np.float32]
    starts: NDArray[np.int64]
    sizes: NDArray[np.int64]


@lru_cache(maxsize=1)
def plaster() -> TexturePyramid:
    """Return the grain that all corridors share; each shape shows another part of it."""
    rng = np.random.default_rng(5)
    tile = sum(
        (
            strength * _noise(sigma, rng)
            for sigma, strength in ((1.2, 0.5), (4.0, 0.45), (16.0, 0.55), (60.0, 0.8))
        ),
        np.zeros((_SIZE, _SIZE), dtype=np.float32),
    )
    tile = tile + 0.35 * _specks(rng)
    tile = (tile - tile.mean()) / tile.std()
    levels = [tile]
    for _ in range(_LEVELS - 1):
        levels.append(cv2.resize(levels[-1], None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA))
    sizes = np.array([len(level) for level in levels], dtype=np.int64)
    starts = np.concatenate([[0], np.cumsum(sizes**2)[:-1]])
    return TexturePyramid(
        np.concatenate([level.ravel() for level in levels]).astype(np.float32), starts.astype(np.int64), sizes
    )


def _noise(sigma: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """Return smooth noise of standard deviation 1 that repeats at the tile's borders."""
    white = rng.standard_normal((_SIZE, _SIZE), dtype=np.float32)
    margin = int(4.0 * sigma) + 1
    smooth = cv2.GaussianBlur(np.pad(white, margin, mode='wrap'), (0, 0), sigma)[
        margin:-margin, margin:-margin
    ]
    return np.asarray(smooth / smooth.std(), dtype=np.float32)


def _specks(rng: np.random.Generator) -> NDArray[np.float32]:
    """Return sparse dark and bright spots of one to three samples."""
    spots = np.zeros((_SIZE, _SIZE), dtype=np.float32)
    rows, columns = rng.integers(0, _SIZE, (2, 2500))
    spots[rows, columns] = rng.choice([-1.0, -1.0, 0.7], 2500)
    spread = cv2.GaussianBlur(np.pad(spots, 8, mode='wrap'), (0, 0), 1.2)[8:-8, 8:-8]
    return np.asarray(spread / spread.std(), dtype=np.float32)
