"""Lamps of one image with their bands: what tells a rolling shutter from a global one, and how fast a lamp flickers."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.lamp_image.lamp_detector import LampDetector, noise_sigma
from vlc_beacon.core.lamp_image.row_profile import row_profile
from vlc_beacon.core.receiver.lamp_decoder import FLICKER_MIN
from vlc_beacon.core.settings import LampSettings

BANDS_MIN = 3
"""Fewest changes between bright and dark along the rows; a half dark lamp has one or two."""
_ANISOTROPY_MIN = 2.0
"""Least variation from row to row over that from column to column: a panel of single LEDs varies along both."""
_DETECTOR = LampDetector(LampSettings(contrast_min=10.0, stripe_rows=20.0))
_SATURATED, _MOST = 254, 0.5
_CORE = 0.6  # half side of the square in a lamp [radii]
_PADDING = 4096  # length of the spectrum [rows]


@dataclass(frozen=True)
class BandedLamp:
    """A lamp in an image.

    Attributes:
        diameter: diameter [px].
        is_saturated: whether most of it is white.
        changes: changes between bright and dark along its rows, 0 for a lamp that varies along its columns too.
        cycles_per_row: frequency of the bands [1/row], NaN for fewer than `BANDS_MIN` changes.
    """

    diameter: float
    is_saturated: bool
    changes: int
    cycles_per_row: float

    @property
    def has_bands(self) -> bool:
        """Whether the lamp shows the bands of a rolling shutter."""
        return self.changes >= BANDS_MIN


def find_banded_lamps(image: NDArray[np.uint8]) -> list[BandedLamp]:
    """Return the lamps of a grey image, shape (h, w)."""
    blobs, noise, lamps = _DETECTOR.detect(image), noise_sigma(image), []
    for centre, radius, background in zip(blobs.centroids, blobs.radii, blobs.backgrounds, strict=True):
        rows = row_profile(image, centre, radius, background, noise)[1]
        (u, v), half = centre.astype(int), max(int(_CORE * radius), 1)
        core = image[max(v - half, 0) : v + half + 1, max(u - half, 0) : u + half + 1]
        along_rows, along_columns = float(np.std(core.mean(axis=1))), float(np.std(core.mean(axis=0)))
        changes = _changes(rows) if along_rows > _ANISOTROPY_MIN * along_columns else 0
        lamps.append(
            BandedLamp(
                diameter=2.0 * float(radius),
                is_saturated=float(np.mean(core >= _SATURATED)) > _MOST,
                changes=changes,
                cycles_per_row=_frequency(rows) if changes >= BANDS_MIN else math.nan,
            )
        )
    return lamps


def _changes(rows: NDArray[np.float64]) -> int:
    """Return how often a lamp's rows change between bright and dark."""
    if not len(rows) or float(np.std(rows)) < FLICKER_MIN:
        return 0
    return int(np.count_nonzero(np.diff(rows > 0.5 * (rows.min() + rows.max()))))


def _frequency(rows: NDArray[np.float64]) -> float:
    """Return the strongest frequency of a lamp's rows [1/row]."""
    spectrum = np.abs(np.fft.rfft((rows - rows.mean()) * np.hanning(len(rows)), _PADDING))
    lowest = int(_PADDING / len(rows))
    return float(lowest + np.argmax(spectrum[lowest:])) / _PADDING
