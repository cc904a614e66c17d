"""Synthetic images of floors from closed formulas, for the tests of dot extraction."""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import erfc

FLOOR = 160.0
DOT = 30.0


def disc_coverage(
    centres: ArrayLike, diameters: ArrayLike, size: tuple[int, int] = (160, 160), blur: float = 0.7
) -> NDArray[np.float64]:
    """Coverage of each pixel (h, w) by discs, with a Gaussian blur of this standard deviation [px]."""
    v, u = np.mgrid[: size[0], : size[1]]
    coverage = np.zeros(size)
    for (x, y), diameter in zip(centres, np.broadcast_to(diameters, len(centres))):
        distance = np.hypot(u - x, v - y)
        coverage = np.maximum(coverage, 0.5 * erfc((distance - diameter / 2) / (2.0**0.5 * blur)))
    return coverage


def photograph(
    coverage: NDArray[np.float64],
    floor: ArrayLike = FLOOR,
    dot: ArrayLike = DOT,
    light: ArrayLike = 1.0,
    noise: float = 0.0,
    seed: int = 0,
) -> NDArray[np.uint8]:
    """Image of a floor with dots, grey or colour, under an illumination and with noise."""
    colour = np.ndim(floor) > 0
    part = coverage[..., None] if colour else coverage
    lamp = np.asarray(light)[..., None] if colour else np.asarray(light)
    levels = lamp * (np.asarray(floor) + part * (np.asarray(dot) - np.asarray(floor)))
    levels = levels + np.random.default_rng(seed).normal(0.0, noise, levels.shape)
    return np.clip(np.rint(levels), 0, 255).astype(np.uint8)


def scattered_centres(
    seed: int, count: int = 14, size: tuple[int, int] = (160, 160), distance: float = 22.0, margin: float = 14.0
) -> NDArray[np.float64]:
    """Random centres u, v, shape (count, 2), with a minimum distance between them."""
    rng = np.random.default_rng(seed)
    centres: list[NDArray[np.float64]] = []
    while len(centres) < count:
        centre = rng.uniform((margin, margin), (size[1] - 1 - margin, size[0] - 1 - margin))
        if not centres or np.hypot(*(np.array(centres) - centre).T).min() > distance:
            centres.append(centre)
    return np.array(centres)


def line_coverage(
    start: tuple[float, float], end: tuple[float, float], width: float, size: tuple[int, int] = (160, 160)
) -> NDArray[np.float64]:
    """Coverage of each pixel (h, w) by a straight hair."""
    v, u = np.mgrid[: size[0], : size[1]]
    a, b = np.array(start), np.array(end)
    along = np.clip(((u - a[0]) * (b - a)[0] + (v - a[1]) * (b - a)[1]) / np.sum((b - a) ** 2), 0.0, 1.0)
    distance = np.hypot(u - a[0] - along * (b - a)[0], v - a[1] - along * (b - a)[1])
    return 0.5 * erfc((distance - width / 2) / (2.0**0.5 * 0.5))


def nearest(pixels: NDArray[np.float64], centres: NDArray[np.float64]) -> NDArray[np.intp]:
    """Index of the nearest detected dot of each true centre, shape (n,)."""
    return np.hypot(*(pixels[None] - centres[:, None]).transpose(2, 0, 1)).argmin(axis=1)


def offsets(pixels: NDArray[np.float64], centres: NDArray[np.float64]) -> NDArray[np.float64]:
    """Offset of the nearest detected dot from each true centre, shape (n, 2) [px]."""
    return pixels[nearest(pixels, centres)] - centres
