"""Observations of images, projected to the map by the states of the images."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.dot_estimation import project_rays_to_map
from floor_localizer.core.survey.observation_blocks import Observations
from floor_localizer.core.survey.survey_image import SurveyImage


@dataclass(frozen=True)
class ProjectedObservations:
    """Observations on the map, grouped by image.

    Attributes:
        observations: the observations, not yet assigned to dots.
        points: projected positions in the map frame, shape (n, 2) [m].
    """

    observations: Observations
    points: NDArray[np.float64]

    def where(self, kept: NDArray[np.bool_]) -> ProjectedObservations:
        """Return the observations selected by a mask, shape (n,)."""
        return ProjectedObservations(self.observations.where(kept), self.points[kept])


def collect_observations(
    images: Sequence[SurveyImage], numbers: NDArray[np.int64], dot_sigma: float
) -> Observations:
    """Return the observations of images, not yet assigned to dots.

    Args:
        images: all images of the survey.
        numbers: indices of the wanted images, shape (j,).
        dot_sigma: standard deviation of a dot on the floor, in addition to image noise [m].
    """
    wanted = [images[number] for number in numbers.tolist()]
    image = np.repeat(numbers, np.array([len(each) for each in wanted], dtype=np.int64))
    directions = np.concatenate([np.empty((0, 3)), *(each.directions for each in wanted)])
    sigmas = np.hypot(np.concatenate([np.empty(0), *(each.sigmas for each in wanted)]), dot_sigma)
    diameters = np.concatenate([np.empty(0), *(each.diameters for each in wanted)])
    return Observations(image, np.full(len(image), -1), directions, sigmas, diameters)


def project_observations(
    observations: Observations, states: NDArray[np.float64], position: NDArray[np.float64]
) -> ProjectedObservations:
    """Project observations to the map.

    Args:
        observations: the observations.
        states: states of all images, shape (k, 6).
        position: optical centre in the base frame, shape (3,) [m].
    """
    return ProjectedObservations(
        observations, project_rays_to_map(observations.directions, position, states[observations.image])
    )
