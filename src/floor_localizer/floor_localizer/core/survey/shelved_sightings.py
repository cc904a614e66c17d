"""The observations of all images in an array store, for tasks in other processes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.placed_sightings import sightings_of
from floor_localizer.core.survey.shelf import Shelf
from floor_localizer.core.survey.sighting_blocks import Sightings
from floor_localizer.core.survey.survey_image import SurveyImage

_IMAGES = 32
"""Number of consecutive images that are stored and read together."""
_NOTHING = sightings_of((), np.empty(0, dtype=np.int64), 0.0)


@dataclass(frozen=True)
class ShelvedSightings:
    """Observations in groups of consecutive images, not yet assigned to dots.

    Attributes:
        shelf: array store of the observations.
        images: number of images.
    """

    shelf: Shelf
    images: int

    @property
    def groups(self) -> int:
        """Number of groups of consecutive images."""
        return -(-self.images // _IMAGES)

    def of_group(self, number: int) -> tuple[NDArray[np.int64], Sightings]:
        """Return the images of a group, ascending, and their observations in that order."""
        images = np.arange(number * _IMAGES, min((number + 1) * _IMAGES, self.images))
        return images, Sightings(*self.shelf.get('seen', number))

    def of_images(self, wanted: NDArray[np.int64]) -> Sightings:
        """Return the observations of images, whose indices are ascending, shape (k,), in that order."""
        found = [_NOTHING]
        for number in np.unique(wanted // _IMAGES).tolist():
            _, seen = self.of_group(number)
            found.append(seen.where(np.isin(seen.image, wanted)))
        return Sightings(*map(np.concatenate, zip(*(each.arrays for each in found), strict=True)))


def shelve_sightings(images: Sequence[SurveyImage], dot_sigma: float, shelf: Shelf) -> ShelvedSightings:
    """Store the observations of images.

    Args:
        images: the images that are on the map.
        dot_sigma: standard deviation of a dot on the floor, in addition to image noise [m].
        shelf: array store.
    """
    shelved = ShelvedSightings(shelf, len(images))
    for number in range(shelved.groups):
        numbers = np.arange(number * _IMAGES, min((number + 1) * _IMAGES, len(images)))
        shelf.put('seen', number, *sightings_of(images, numbers, dot_sigma).arrays)
    return shelved
