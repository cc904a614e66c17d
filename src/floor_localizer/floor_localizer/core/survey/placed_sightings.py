"""What images saw, laid on the map by their states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.placed_dots import map_points
from floor_localizer.core.survey.sighting_blocks import Sightings
from floor_localizer.core.survey.survey_image import SurveyImage


@dataclass(frozen=True)
class Placed:
    """Sightings on the map, those of an image next to each other.

    Attributes:
        seen: the sightings, not yet of any dot.
        points: shape (n, 2), where they lie [m].
    """

    seen: Sightings
    points: NDArray[np.float64]

    def where(self, kept: NDArray[np.bool_]) -> Placed:
        """Return those that are kept."""
        return Placed(self.seen.where(kept), self.points[kept])


def sightings_of(images: Sequence[SurveyImage], numbers: NDArray[np.int64], dot_sigma: float) -> Sightings:
    """Return what images saw, not yet of any dot.

    Args:
        images: of the survey.
        numbers: shape (j,), of those that are wanted.
        dot_sigma: accuracy of a dot on the floor besides noise [m].
    """
    wanted = [images[number] for number in numbers.tolist()]
    image = np.repeat(numbers, np.array([len(each) for each in wanted], dtype=np.int64))
    directions = np.concatenate([np.empty((0, 3)), *(each.directions for each in wanted)])
    sigmas = np.hypot(np.concatenate([np.empty(0), *(each.sigmas for each in wanted)]), dot_sigma)
    diameters = np.concatenate([np.empty(0), *(each.diameters for each in wanted)])
    return Sightings(image, np.full(len(image), -1), directions, sigmas, diameters)


def placed(seen: Sightings, states: NDArray[np.float64], position: NDArray[np.float64]) -> Placed:
    """Lay sightings on the map.

    Args:
        seen: the sightings.
        states: shape (k, 6), of all images.
        position: of the optical centre [m].
    """
    return Placed(seen, map_points(seen.directions, position, states[seen.image]))
