"""Dot detector, in the steps of the paper (3.1)."""

import cv2
import numpy as np

from floor_localizer.core.arrays import Pixels
from floor_localizer.core.dot_extraction.binarisation import (
    binarise,
    contrast_threshold,
    smooth_background,
    upsample,
)
from floor_localizer.core.dot_extraction.centroids import Blobs, measure_blobs
from floor_localizer.core.dot_extraction.labelling import grow_labels, label_blobs
from floor_localizer.core.dot_extraction.noise_removal import (
    are_dots,
    blob_elongations,
    centroid_sigmas,
    typical_diameter,
)
from floor_localizer.core.dot_extraction.polarity import choose_polarity
from floor_localizer.core.dot_extraction.splitting import split_touching
from floor_localizer.core.dots import DetectedDots
from floor_localizer.core.errors import DotImageError
from floor_localizer.core.settings import DotDetectorSettings
from shirube_core.settings import SettingsError, check_settings

SMALLEST_SIDE = 32
"""Minimum side of an image [px]."""

SPECK_AREA_FRACTION = 0.5
"""Minimum area of a blob, as a fraction of the smallest dot's area; smaller blobs are noise."""

MIN_PART_DIAMETER = 0.55
"""Minimum diameter of a dot split from a blob, as a fraction of the typical dot's diameter; hairs are thinner."""


class DotDetector:
    """Detects the dots in images of a floor."""

    def __init__(self, settings: DotDetectorSettings | None = None) -> None:
        """Create a detector.

        Args:
            settings: settings of dot extraction, None for the defaults.

        Raises:
            SettingsError: a setting is outside its range.
        """
        self.settings = settings or DotDetectorSettings()
        check_settings(self.settings)
        smallest, largest = self.settings.minimum_diameter, self.settings.maximum_diameter
        if 0.0 < largest <= smallest:
            raise SettingsError(
                f'setting maximum_diameter is {largest:g} px, it must be more than '
                f'minimum_diameter ({smallest:g} px), or 0'
            )

    def detect(self, image: Pixels) -> DetectedDots:
        """Detect the dots of one image.

        Args:
            image: shape (h, w) grey or (h, w, 3) blue, green, red; uint8; not modified.

        Returns:
            the dots in raw image coordinates, in arbitrary order; none on an empty floor.

        Raises:
            DotImageError: the image is of another type or shape, or too small.
        """
        check_image(image)
        height, width = image.shape[:2]
        smallest, largest = self.settings.minimum_diameter, self.settings.largest_diameter(width, height)
        image, polarity = self._select_channels(image, largest)
        smooth = cv2.GaussianBlur(image, (5, 5), 1.0).reshape(image.shape)

        background = smooth_background(smooth, polarity, largest)
        threshold = contrast_threshold(smooth, background, polarity, self.settings)
        mask = binarise(smooth, background, polarity, threshold)
        background = upsample(background, width, height)
        labels, boxes = label_blobs(mask, SPECK_AREA_FRACTION * 0.25 * np.pi * smallest**2)
        typical = typical_diameter(boxes[:, 4].astype(np.float64), smallest, largest)
        boxes, split = split_touching(
            labels, boxes, image, background, polarity, max(smallest, MIN_PART_DIAMETER * typical), largest
        )

        grow_labels(labels, boxes)
        blobs = measure_blobs(image, background, mask, labels, boxes)
        elongations = blob_elongations(blobs)
        kept = are_dots(blobs, elongations, largest, self.settings)
        blobs = Blobs(*(column[kept] for column in blobs))
        sigmas = centroid_sigmas(blobs, elongations[kept], split[kept])
        return DetectedDots(blobs.pixels, blobs.diameters, sigmas)

    def _select_channels(self, image: Pixels, largest: float) -> tuple[Pixels, str]:
        # The image as (h, w, 1) if brightness distinguishes the dots, else as (h, w, 3); and the polarity.
        polarity = self.settings.polarity
        planes = np.ascontiguousarray(image).reshape(*image.shape[:2], -1)
        if polarity == 'auto':
            polarity = choose_polarity(planes, largest)
        if planes.shape[2] == 3 and polarity != 'any':
            planes = cv2.cvtColor(planes, cv2.COLOR_BGR2GRAY)[..., None]
        return planes, polarity


def check_image(image: Pixels) -> None:
    """Check type, shape and size of an image.

    Raises:
        DotImageError: one line with the type or shape and what is expected.
    """
    if not isinstance(image, np.ndarray) or image.dtype != np.uint8:
        kind = f'{image.dtype} values' if isinstance(image, np.ndarray) else type(image).__name__
        raise DotImageError(f'the image holds {kind}, it must be an array of uint8 (mono8 or bgr8)')
    if image.ndim not in (2, 3) or (image.ndim == 3 and image.shape[2] != 3):
        raise DotImageError(
            f'the image has the shape {image.shape}, it must be (h, w) or (h, w, 3) (mono8 or bgr8)'
        )
    if min(image.shape[:2]) < SMALLEST_SIDE:
        raise DotImageError(
            f'the image is {image.shape[1]} x {image.shape[0]} px, '
            f'each side must be at least {SMALLEST_SIDE} px'
        )
