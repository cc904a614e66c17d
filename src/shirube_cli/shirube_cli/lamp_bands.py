"""Bands of the lamps in an image, which distinguish a rolling shutter from a global one."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.lamp_image.lamp_detector import LampDetector, noise_sigma
from vlc_beacon.core.lamp_image.row_profile import row_profile
from vlc_beacon.core.receiver.lamp_decoder import FLICKER_MIN
from vlc_beacon.core.settings import LampSettings

BANDS_MIN = 3  # fewest changes between bright and dark along the rows; a half dark lamp has one or two
_ANISOTROPY_MIN = 2.0
"""Least variation from row to row over that from column to column: a panel of single LEDs varies along both."""
_DETECTOR = LampDetector(LampSettings(contrast_min=10.0, stripe_rows=20.0))
_CORE = 0.6  # half side of the square in a lamp [radii]
_SATURATED = 250.0  # median of that square [grey levels]


@dataclass(frozen=True)
class BandedLamp:
    """A lamp in an image.

    Attributes:
        pixel: u and v of its middle [px].
        diameter: diameter [px].
        changes: how often its rows change between bright and dark; 0 for a lamp that varies along its columns, too.
        brightness: brightness of its rows relative to full light, shape (n,).
        is_saturated: whether its middle is white.
    """

    pixel: tuple[int, int]
    diameter: float
    changes: int
    brightness: NDArray[np.float64]
    is_saturated: bool

    @property
    def cycles_per_row(self) -> float:
        """Cycles of the light in the time of a row; 0 without bands."""
        return 0.5 * self.changes / len(self.brightness) if self.changes >= BANDS_MIN else 0.0


def find_banded_lamps(image: NDArray[np.uint8]) -> list[BandedLamp]:
    """Return the lamps of a grey image, shape (h, w)."""
    blobs, noise, lamps = _DETECTOR.detect(image), noise_sigma(image), []
    for centre, radius, background in zip(blobs.centroids, blobs.radii, blobs.backgrounds, strict=True):
        rows = row_profile(image, centre, radius, background, noise)[1]
        (u, v), half = centre.astype(int), max(int(_CORE * radius), 1)
        core = image[max(v - half, 0) : v + half + 1, max(u - half, 0) : u + half + 1]
        along_rows, along_columns = float(np.std(core.mean(axis=1))), float(np.std(core.mean(axis=0)))
        changes = _changes(rows) if along_rows > _ANISOTROPY_MIN * along_columns else 0
        lamps.append(BandedLamp((u, v), 2.0 * float(radius), changes, rows, bool(np.median(core) >= _SATURATED)))
    return lamps


def count_band_changes(image: NDArray[np.uint8]) -> list[int]:
    """Return of each lamp in a grey image, shape (h, w), how often its rows change between bright and dark."""
    return [lamp.changes for lamp in find_banded_lamps(image)]


def _changes(rows: NDArray[np.float64]) -> int:
    if not len(rows) or float(np.std(rows)) < FLICKER_MIN:
        return 0
    return int(np.count_nonzero(np.diff(rows > 0.5 * (rows.min() + rows.max()))))
