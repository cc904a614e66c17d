"""What the images of a survey saw, on a shelf, so that tasks in other processes have it without the images."""

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
"""That follow each other in the drive and are read together."""
_NOTHING = sightings_of((), np.empty(0, dtype=np.int64), 0.0)


@dataclass(frozen=True)
class ShelvedSightings:
    """Sightings of the images, some images' together; none is of a dot yet.

    Attributes:
        shelf: where they are.
        images: number of the images.
    """

    shelf: Shelf
    images: int

    @property
    def groups(self) -> int:
        """Number of groups of images that follow each other."""
        return -(-self.images // _IMAGES)

    def of_group(self, number: int) -> tuple[NDArray[np.int64], Sightings]:
        """Return the images of a group, rising, and what they saw, in their order."""
        images = np.arange(number * _IMAGES, min((number + 1) * _IMAGES, self.images))
        return images, Sightings(*self.shelf.get('seen', number))

    def of_images(self, wanted: NDArray[np.int64]) -> Sightings:
        """Return what images saw, shape (k,), rising, in their order."""
        found = [_NOTHING]
        for number in np.unique(wanted // _IMAGES).tolist():
            _, seen = self.of_group(number)
            found.append(seen.where(np.isin(seen.image, wanted)))
        return Sightings(*map(np.concatenate, zip(*(each.arrays for each in found), strict=True)))


def shelve_sightings(images: Sequence[SurveyImage], dot_sigma: float, shelf: Shelf) -> ShelvedSightings:
    """Put what images saw on a shelf.

    Args:
        images: those that are on the map.
        dot_sigma: accuracy of a dot on the floor besides noise [m].
        shelf: for it.
    """
    shelved = ShelvedSightings(shelf, len(images))
    for number in range(shelved.groups):
        numbers = np.arange(number * _IMAGES, min((number + 1) * _IMAGES, len(images)))
        shelf.put('seen', number, *sightings_of(images, numbers, dot_sigma).arrays)
    return shelved
