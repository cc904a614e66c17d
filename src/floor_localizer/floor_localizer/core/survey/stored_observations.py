"""The observations of all images in an array store, for tasks in other processes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.array_store import ArrayStore
from floor_localizer.core.survey.observation_blocks import Observations
from floor_localizer.core.survey.projected_observations import collect_observations
from floor_localizer.core.survey.survey_image import SurveyImage

_GROUP_SIZE = 32
"""Number of consecutive images that are stored and read together."""
_EMPTY = collect_observations((), np.empty(0, dtype=np.int64), 0.0)


@dataclass(frozen=True)
class StoredObservations:
    """Observations in groups of consecutive images, not yet assigned to dots.

    Attributes:
        store: array store of the observations.
        images: number of images.
    """

    store: ArrayStore
    images: int

    @property
    def group_count(self) -> int:
        """Number of groups of consecutive images."""
        return -(-self.images // _GROUP_SIZE)

    def read_group(self, number: int) -> tuple[NDArray[np.int64], Observations]:
        """Return the images of a group, ascending, and their observations in that order."""
        images = np.arange(number * _GROUP_SIZE, min((number + 1) * _GROUP_SIZE, self.images))
        return images, Observations(*self.store.get('seen', number))

    def read_images(self, wanted: NDArray[np.int64]) -> Observations:
        """Return the observations of images, whose indices are ascending, shape (k,), in that order."""
        found = [_EMPTY]
        for number in np.unique(wanted // _GROUP_SIZE).tolist():
            _, observations = self.read_group(number)
            found.append(observations.where(np.isin(observations.image, wanted)))
        return Observations(*map(np.concatenate, zip(*(each.arrays for each in found), strict=True)))


def store_observations(
    images: Sequence[SurveyImage], dot_sigma: float, store: ArrayStore
) -> StoredObservations:
    """Store the observations of images.

    Args:
        images: the images that are on the map.
        dot_sigma: standard deviation of a dot on the floor, in addition to image noise [m].
        store: array store.
    """
    stored = StoredObservations(store, len(images))
    for number in range(stored.group_count):
        numbers = np.arange(number * _GROUP_SIZE, min((number + 1) * _GROUP_SIZE, len(images)))
        store.put('seen', number, *collect_observations(images, numbers, dot_sigma).arrays)
    return stored
