"""Scale a map by one measured length."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.survey.floor_survey import SurveyResult

# Search radius around the given position of a dot [m].
_SEARCH_RADIUS = 0.01
# Largest relative difference between the tape and the camera's calibration.
_MAX_SCALE_CHANGE = 0.1


@dataclass(frozen=True)
class KnownLength:
    """A measured distance.

    Attributes:
        first: position of a dot on the map before scaling, shape (2,) [m].
        second: position of the other dot, shape (2,) [m].
        length: measured distance between their centres [m].
    """

    first: NDArray[np.float64]
    second: NDArray[np.float64]
    length: float


def scale_survey(result: SurveyResult, known: KnownLength) -> tuple[SurveyResult, float]:
    """Return the survey scaled to a known length, and the scale factor.

    Raises:
        FloorLocalizerError: no dot is at a given position, or the length is implausible.
    """
    ends = np.array([_dot_at(result.dot_map, position) for position in (known.first, known.second)])
    mapped = float(np.hypot(*(ends[1] - ends[0])))
    if mapped < 2.0 * _SEARCH_RADIUS or not abs(known.length / mapped - 1.0) < _MAX_SCALE_CHANGE:
        raise FloorLocalizerError(
            f'--known-length: is {known.length:g} m, but the dots are {mapped:.4f} m apart on the map; '
            'check which dots were measured, and camera_xyz'
        )
    scale = known.length / mapped
    states = result.states.copy()
    states[:, :2] *= scale
    states[:, 3] = scale * (1.0 + states[:, 3]) - 1.0
    dot_map = DotMap(scale * result.dot_map.points, scale * result.dot_map.diameters)
    residuals = replace(result.residuals, scale=scale * result.residuals.scale)
    return replace(result, dot_map=dot_map, states=states, residuals=residuals), scale


def _dot_at(dot_map: DotMap, position: NDArray[np.float64]) -> NDArray[np.float64]:
    distances = np.hypot(*(dot_map.points - position).T)
    nearest = int(np.argmin(distances))
    if distances[nearest] > _SEARCH_RADIUS:
        raise FloorLocalizerError(
            f'--known-length: ({position[0]:g}, {position[1]:g}) m has no dot within {1e3 * _SEARCH_RADIUS:.0f} mm; '
            'give the positions of two dots as they are in the map without --known-length'
        )
    return dot_map.points[nearest]
