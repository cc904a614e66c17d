"""Normal equations of some images of a survey."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

UNKNOWNS_PER_IMAGE = 6


@dataclass(frozen=True)
class NormalEquations:
    """Normal equations of some images, with six unknowns each.

    Attributes:
        images: indices of the images, ascending, shape (k,).
        normal: symmetric normal matrix, shape (6 k, 6 k).
        gradient: gradient, shape (6 k,).
    """

    images: NDArray[np.int64]
    normal: NDArray[np.float64]
    gradient: NDArray[np.float64]

    def __add__(self, other: NormalEquations) -> NormalEquations:
        """Return the sum of both, over the union of their images."""
        images = np.union1d(self.images, other.images)
        total = NormalEquations(
            images,
            np.zeros((UNKNOWNS_PER_IMAGE * len(images), UNKNOWNS_PER_IMAGE * len(images))),
            np.zeros(UNKNOWNS_PER_IMAGE * len(images)),
        )
        for each in (self, other):
            rows = unknown_indices(np.searchsorted(images, each.images))
            total.normal[np.ix_(rows, rows)] += each.normal
            total.gradient[rows] += each.gradient
        return total


def unknown_indices(images: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the indices of the unknowns of images, shape (6 k,)."""
    return (UNKNOWNS_PER_IMAGE * images[:, None] + np.arange(UNKNOWNS_PER_IMAGE)).ravel()
