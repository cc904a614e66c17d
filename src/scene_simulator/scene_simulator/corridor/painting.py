"""Painting of textured outlines with exact area coverage of every sample, in time linear in outline and area.

The texture is the grain of walls and floors: stains, plaster and specks, averaged beforehand for distant views.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from scene_simulator.imaging.sensors import clip_integral

SPACING = 0.004  # distance of the finest samples [m]: the tile repeats after 4.1 m
_SIZE = 1024
_LEVELS = 7
Texture = tuple[NDArray[np.float32], NDArray[np.int64], NDArray[np.int64]]
"""Samples, starts and sizes of a ``TexturePyramid``."""

SAMPLES = 2  # samples per pixel along each side: fine enough that a blur of samples is a blur of what is within pixels
_FAINT = 1e-5
_DARKEST = 0.02  # least light on a surface: a gradient of the light must not turn it negative far away


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
        (strength * _noise(sigma, rng) for sigma, strength in ((1.2, 0.5), (4.0, 0.45), (16.0, 0.55), (60.0, 0.8))),
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
    smooth = cv2.GaussianBlur(np.pad(white, margin, mode='wrap'), (0, 0), sigma)[margin:-margin, margin:-margin]
    return np.asarray(smooth / smooth.std(), dtype=np.float32)


def _specks(rng: np.random.Generator) -> NDArray[np.float32]:
    """Return sparse dark and bright spots of one to three samples."""
    spots = np.zeros((_SIZE, _SIZE), dtype=np.float32)
    rows, columns = rng.integers(0, _SIZE, (2, 2500))
    spots[rows, columns] = rng.choice([-1.0, -1.0, 0.7], 2500)
    spread = cv2.GaussianBlur(np.pad(spots, 8, mode='wrap'), (0, 0), 1.2)[8:-8, 8:-8]
    return np.asarray(spread / spread.std(), dtype=np.float32)


@njit(cache=True, error_model='numpy')
def paint_outline(
    picture: NDArray[np.float32],
    sums: NDArray[np.float32],
    outline: NDArray[np.float64],
    rays: NDArray[np.float32],
    shading: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    texture: Texture,
) -> None:
    """Paint one outline over a picture.

    A sample that the outline covers by the fraction a becomes ``(1 - a * opacity) * sample + a * opacity * light``.

    Args:
        picture: shape (height, width), changed in place.
        sums: shape (height, width + 2), zero, and left zero.
        outline: shape (n, 2), inside the picture, whose upper left corner is the origin [samples].
        rays: shape (height / SAMPLES, width / SAMPLES, 2), rays of the pixels, z = 1; a surface's
            light is the same in all samples of a pixel.
        shading: paint (grey, grain, opacity, shifts); matrix from rays to the plane's places, shape (3, 3); light at
            the plane's origin, its slopes to the right and up [1/m], width of a pixel at a distance of 1 [m].
        texture: the grain.
    """
    height, width = picture.shape
    top, bottom = math.floor(outline[:, 1].min()), min(height, math.ceil(outline[:, 1].max()))
    left, right = math.floor(outline[:, 0].min()), min(width, math.ceil(outline[:, 0].max()))
    lights = np.empty(rays.shape[1])
    _add_edges(sums, outline)
    for row in range(top, bottom):
        if row == top or row % SAMPLES == 0:
            lights[left // SAMPLES : (right - 1) // SAMPLES + 1] = np.nan
        covered = np.float32(0.0)
        for column in range(left, right):
            covered += sums[row, column]
            sums[row, column] = 0.0
            alpha = min(abs(covered), np.float32(1.0)) * shading[0][2]
            if alpha > _FAINT:
                pixel = column // SAMPLES
                if math.isnan(lights[pixel]):
                    ray = rays[row // SAMPLES, pixel]
                    lights[pixel] = _light(ray[0], ray[1], shading, texture)
                picture[row, column] += alpha * (lights[pixel] - picture[row, column])
        sums[row, right : right + 2] = 0.0


@njit(cache=True, error_model='numpy')
def _add_edges(sums: NDArray[np.float32], outline: NDArray[np.float64]) -> None:
    """Add what each edge changes of the coverage from one sample to the next: the running sum is the coverage."""
    for i in range(len(outline)):
        x0, y0 = outline[i - 1]
        x1, y1 = outline[i]
        if y0 == y1:
            continue
        slope = (x1 - x0) / (y1 - y0)
        sign = 1.0 if y1 > y0 else -1.0
        low, high = min(y0, y1), max(y0, y1)
        for row in range(math.floor(low), math.ceil(high)):
            enter, leave = max(low, row), min(high, row + 1)
            xa, xb = x0 + slope * (enter - y0), x0 + slope * (leave - y0)
            _add_edge_segment(sums[row], min(xa, xb), max(xa, xb), sign * (leave - enter))


@njit(cache=True, error_model='numpy')
def _add_edge_segment(sums: NDArray[np.float32], low: float, high: float, rise: float) -> None:
    """Add an edge segment within a row, from ``low`` to ``high``, that rises by a fraction of the row."""
    first = max(0, math.floor(low))
    before = 0.0
    for column in range(first, math.ceil(high) + 1):
        area = rise * _mean_fraction_left(column + 1.0, low, high)
        sums[column] += area - before
        before = area


@njit(cache=True, error_model='numpy')
def _mean_fraction_left(side: float, low: float, high: float) -> float:
    """Return the mean, over an edge segment, of the fraction of a sample right of the segment."""
    if high - low < 1e-9:
        return min(max(side - 0.5 * (low + high), 0.0), 1.0)
    return (clip_integral(side - low) - clip_integral(side - high)) / (high - low)


@njit(cache=True, error_model='numpy')
def _light(
    x: float, y: float, shading: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]], texture: Texture
) -> float:
    """Return the light that a plane sends along a ray."""
    paint, plane, lamp = shading
    w = 1.0 / (plane[2, 0] * x + plane[2, 1] * y + plane[2, 2])
    s = (plane[0, 0] * x + plane[0, 1] * y + plane[0, 2]) * w
    t = (plane[1, 0] * x + plane[1, 1] * y + plane[1, 2]) * w
    light = paint[0] * max(lamp[0] + lamp[1] * s + lamp[2] * t, _DARKEST)
    if paint[1] == 0.0:
        return light
    along_s = (plane[0, 0] - s * plane[2, 0]) ** 2 + (plane[0, 1] - s * plane[2, 1]) ** 2
    along_t = (plane[1, 0] - t * plane[2, 0]) ** 2 + (plane[1, 1] - t * plane[2, 1]) ** 2
    footprint_square = max(along_s, along_t) * (lamp[3] * w) ** 2
    return light * (1.0 + paint[1] * _grain(s + paint[3], t + paint[4], footprint_square, texture))


@njit(cache=True, error_model='numpy')
def _grain(s: float, t: float, footprint_square: float, texture: Texture) -> float:
    """Return the texture at a place, averaged over the square of a footprint's side [m^2]."""
    samples, starts, sizes = texture
    level, spacing = 0, SPACING
    while footprint_square > spacing * spacing and level < len(sizes) - 1:
        level += 1
        spacing *= 2.0
    size, start = sizes[level], starts[level]
    column, row = s / spacing - 0.5, t / spacing - 0.5
    i, j = math.floor(column), math.floor(row)
    u, v = column - i, row - j
    # Sizes are powers of two.
    i0, i1 = i & (size - 1), (i + 1) & (size - 1)
    j0, j1 = start + (j & (size - 1)) * size, start + ((j + 1) & (size - 1)) * size
    low = samples[j0 + i0] + u * (samples[j0 + i1] - samples[j0 + i0])
    high = samples[j1 + i0] + u * (samples[j1 + i1] - samples[j1 + i0])
    return low + v * (high - low)
