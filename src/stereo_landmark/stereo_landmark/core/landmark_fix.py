"""What a pair of images tells: the place, the displacement from it and the targets, or why there is none."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shirube_geometry import PlanarPose, matrix_from_rpy
from stereo_landmark.core.place.place_fix import NoPlaceFix, PlaceFix
from stereo_landmark.core.procedure.sighting import NoSightingReason, NoTargetSighting, TargetSighting
from stereo_landmark.core.procedure.taught_place import TaughtPlace

Sighting = TargetSighting | NoTargetSighting
_STAGES = (NoSightingReason.NO_CANDIDATE, NoSightingReason.NO_EVIDENCE, NoSightingReason.AMBIGUOUS)
"""How far the search for a target came, the earliest end first."""


@dataclass(frozen=True)
class LandmarkFix:
    """The robot at a taught place.

    Attributes:
        place: the place.
        displacement: from its taught pose.
        sightings: of its targets, found or not.
        compared: names of the primitives that were compared with the taught images; outlines told the others.
    """

    place: TaughtPlace
    displacement: PlaceFix
    sightings: tuple[Sighting, ...]
    compared: tuple[str, ...] = ()

    @property
    def T_map_base(self) -> PlanarPose | None:  # noqa: N802
        """The robot in the map, None where nobody told where the place is."""
        T_map_place = self.place.T_map_place
        return None if T_map_place is None else T_map_place @ self.displacement.T_place_base

    @property
    def map_covariance(self) -> NDArray[np.float64]:
        """Of x, y [m] and yaw [rad] in the map, shape (3, 3); of the place's own frame where no map is known."""
        T_map_place = self.place.T_map_place
        turn = matrix_from_rpy((0.0, 0.0, 0.0 if T_map_place is None else T_map_place.yaw))
        planar = self.displacement.covariance[np.ix_([0, 1, 3], [0, 1, 3])]
        return np.asarray(turn @ planar @ turn.T)

    @property
    def evidence(self) -> float:
        """Log likelihood above chance, of all targets."""
        return sum(each.evidence for each in self.sightings if isinstance(each, TargetSighting))


@dataclass(frozen=True)
class NoLandmarkFix:
    """No pose, and why.

    Attributes:
        reason: in words, the same for the same kind of failure.
        detail: numbers and names to it, for the diagnostics.
        sightings: of the targets of the place that was nearest to a fix.
    """

    reason: str
    detail: str
    sightings: tuple[Sighting, ...] = ()

    @property
    def progress(self) -> tuple[int, float]:
        """How far the search came, to be compared: the stage of its best target, and the evidence for those found."""
        found = [each for each in self.sightings if isinstance(each, TargetSighting)]
        stages = [
            _STAGES.index(each.reason) if isinstance(each, NoTargetSighting) else len(_STAGES)
            for each in self.sightings
        ]
        return max(stages, default=0), sum(each.evidence for each in found)


def no_fix_of(place: TaughtPlace, sightings: tuple[Sighting, ...], fault: NoPlaceFix) -> NoLandmarkFix:
    """Return why a place gave no pose: what was wrong with its points, or that no target of it was found.

    Args:
        place: the place.
        sightings: of its targets.
        fault: what was wrong with the points of those that were found.
    """
    missing = [each for each in sightings if isinstance(each, NoTargetSighting)]
    if len(missing) < len(sightings):
        return NoLandmarkFix(fault.reason.value, f'place {place.name}: {fault.detail}', sightings)
    reason = missing[0].reason.value
    detail = '; '.join(f'{each.target}: {each.reason.value} ({each.detail})' for each in missing)
    return NoLandmarkFix(reason, f'place {place.name}: {detail}', sightings)
