"""Detects lamps in a grey image: coarse contrast, candidates, then measurements at full resolution."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.lamp_image import blob_measurement as blob
from vlc_beacon.core.lamp_image.candidates import find_candidates
from vlc_beacon.core.lamp_image.coarse_contrast import CELL, coarse_contrast, noise_sigma
from vlc_beacon.core.lamp_image.lamp_blobs import LampBlobs
from vlc_beacon.core.lamp_image.lamp_image_error import LampImageError
from vlc_beacon.core.lamp_image.settings import LampSettings
from vlc_beacon.core.lamp_image.striped_disc import fit_striped_disc

SIGMA_MIN = 0.02
"""Lower bound of the centroid standard deviation, due to pixel non-uniformity [px]."""
SIDE_MIN = 16
"""Minimum image side [px]."""
DUPLICATE_RADIUS_FRACTION = 0.5
"""Blobs whose centres are closer than this fraction of a radius are duplicates."""


class LampDetector:
    """Lamp detector."""

    def __init__(self, settings: LampSettings | None = None) -> None:
        """Set the lamp settings; None for the defaults."""
        self._settings = settings or LampSettings()

    def detect(self, image: NDArray[np.uint8]) -> LampBlobs:
        """Return the lamps of an image, brightest first.

        Args:
            image: grey image, shape (h, w).

        Raises:
            LampImageError: the image has a wrong type or shape.
        """
        _check(image)
        settings = self._settings
        contrast, _ = coarse_contrast(image, settings.diameter_max, settings.stripe_rows)
        noise = noise_sigma(image)
        lowest = max(settings.contrast_min, settings.noise_sigmas * noise / CELL)
        boxes, peaks = find_candidates(contrast, lowest, settings)
        stripe_rows = round(settings.stripe_rows)
        limits = settings.diameter_min, settings.diameter_max, settings.roundness_min
        found: list[NDArray[np.float64]] = []
        for box, peak in zip(boxes, peaks, strict=True):
            measures = blob.measure_blob(image, box, peak, noise, stripe_rows, limits)
            if (
                measures[blob.AREA] > 0.0
                and _is_whole(measures, image.shape)
                and not any(_are_duplicates(measures, other) for other in found)
            ):
                found.append(measures)
        blobs = _blobs(np.array(found).reshape(-1, blob.MEASURES))
        return fit_striped_disc(image, blobs, noise) if stripe_rows > 0 else blobs


def _check(image: NDArray[np.uint8]) -> None:
    if image.dtype != np.uint8 or image.ndim != 2:
        raise LampImageError(
            f'the image has type {image.dtype} and {image.ndim} dimensions; give a grey image of type uint8'
        )
    if min(image.shape) < SIDE_MIN:
        height, width = image.shape
        raise LampImageError(
            f'the image has {width} x {height} pixels; give one of {SIDE_MIN} x {SIDE_MIN} or more'
        )


def _is_whole(measures: NDArray[np.float64], shape: tuple[int, ...]) -> bool:
    u, v, radius = measures[[blob.U, blob.V, blob.RADIUS]]
    return bool(radius <= u <= shape[1] - 1 - radius and radius <= v <= shape[0] - 1 - radius)


def _are_duplicates(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    distance = np.hypot(a[blob.U] - b[blob.U], a[blob.V] - b[blob.V])
    return bool(distance < DUPLICATE_RADIUS_FRACTION * max(a[blob.RADIUS], b[blob.RADIUS]))


def _blobs(measures: NDArray[np.float64]) -> LampBlobs:
    centroids, radii = measures[:, [blob.U, blob.V]], measures[:, blob.RADIUS]
    sigma = np.hypot(measures[:, blob.SIGMA], SIGMA_MIN)
    return LampBlobs(
        centroids,
        np.column_stack([sigma, sigma]),
        radii,
        measures[:, blob.ROUNDNESS],
        measures[:, blob.BRIGHTNESS],
        measures[:, blob.BACKGROUND],
    )
