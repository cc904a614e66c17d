"""Bands of the lamps in an image, which distinguish a rolling shutter from a global one."""

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
_CORE = 0.6  # half side of the square in a lamp [radii]


def count_band_changes(image: NDArray[np.uint8]) -> list[int]:
    """Return of each lamp in a grey image, shape (h, w), how often its rows change between bright and dark.

    It is 0 for a lamp that varies along its columns, too.
    """
    blobs, noise, counts = _DETECTOR.detect(image), noise_sigma(image), []
    for centre, radius, background in zip(blobs.centroids, blobs.radii, blobs.backgrounds, strict=True):
        rows = row_profile(image, centre, radius, background, noise)[1]
        (u, v), half = centre.astype(int), max(int(_CORE * radius), 1)
        core = image[max(v - half, 0) : v + half + 1, max(u - half, 0) : u + half + 1]
        along_rows, along_columns = float(np.std(core.mean(axis=1))), float(np.std(core.mean(axis=0)))
        counts.append(_changes(rows) if along_rows > _ANISOTROPY_MIN * along_columns else 0)
    return counts


def _changes(rows: NDArray[np.float64]) -> int:
    if not len(rows) or float(np.std(rows)) < FLICKER_MIN:
        return 0
    return int(np.count_nonzero(np.diff(rows > 0.5 * (rows.min() + rows.max()))))
