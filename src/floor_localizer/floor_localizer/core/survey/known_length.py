"""The scale of a map from one length that was measured."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.survey.floor_survey import SurveyResult

# A dot is where it is said to be within this [m].
_REACH = 0.01
# A tape does not disagree with the camera's calibration by more than this share.
_DISAGREEMENT = 0.1


@dataclass(frozen=True)
class KnownLength:
    """A measured distance.

    Attributes:
        first: place of a dot on the map as it is without this length, shape (2,) [m].
        second: place of the other dot, shape (2,) [m].
        length: between the middles of both [m].
    """

    first: NDArray[np.float64]
    second: NDArray[np.float64]
    length: float


def scale_survey(result: SurveyResult, known: KnownLength) -> tuple[SurveyResult, float]:
    """Return the survey at the scale of a known length, and by how much it is larger.

    Raises:
        FloorLocalizerError: there is no dot, or the length cannot be right.
    """
    ends = np.array([_dot_at(result.dot_map, place) for place in (known.first, known.second)])
    mapped = float(np.hypot(*(ends[1] - ends[0])))
    if mapped < 2.0 * _REACH or not abs(known.length / mapped - 1.0) < _DISAGREEMENT:
        raise FloorLocalizerError(
            f'--known-length: {known.length:g} m lie between dots that are {mapped:.4f} m apart on the map; '
            'check which dots were measured, and camera_xyz'
        )
    scale = known.length / mapped
    states = result.states.copy()
    states[:, :2] *= scale
    states[:, 3] = scale * (1.0 + states[:, 3]) - 1.0
    dot_map = DotMap(scale * result.dot_map.points, scale * result.dot_map.diameters)
    residuals = replace(result.residuals, scale=scale * result.residuals.scale)
    return replace(result, dot_map=dot_map, states=states, residuals=residuals), scale


def _dot_at(dot_map: DotMap, place: NDArray[np.float64]) -> NDArray[np.float64]:
    distances = np.hypot(*(dot_map.points - place).T)
    nearest = int(np.argmin(distances))
    if distances[nearest] > _REACH:
        raise FloorLocalizerError(
            f'--known-length: ({place[0]:g}, {place[1]:g}) m has no dot within {1e3 * _REACH:.0f} mm; '
            'give the places of two dots as they are in the map without --known-length'
        )
    return dot_map.points[nearest]
