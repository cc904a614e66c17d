"""Photographs of a simulated floor at places all over it, with the localizer that knows the floor's map."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from _pose_scores import PoseScore, score_pose
from numpy.typing import NDArray

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dots import DotMap
from floor_localizer.core.fix import PosePrior
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.settings import LocalizerSettings, TrackerSettings
from scene_simulator.floor.demo_scene import DEMO_CAMERA, DEMO_FLOOR_SEED
from scene_simulator.floor.dot_floor import (
    DARK_ON_LIGHT,
    SURVEY_ERROR,
    DotFloor,
    FloorDesign,
    generate_dot_floor,
    survey_floor,
)
from shirube_core.geometry import SE2, CameraMount

MOUNT = CameraMount()
CAMERA = DEMO_CAMERA
PRIOR_DISTANCE, PRIOR_TURN = 0.002, math.radians(1.0)
MARGIN = 0.07  # A view at this distance from the floor's border is on the floor at every yaw [m]

# Powers of the inverse of the root of g^4 = g + 1: their multiples fill a cube evenly (Roberts 2018).
_EVEN_STEPS = np.array([1.2207440846057596**-power for power in (1, 2, 3)])


@dataclass
class Outcome:
    """What came of the images of one condition, without and with a prior."""

    scores: list[PoseScore] = field(default_factory=list)
    tracked: list[PoseScore] = field(default_factory=list)


@dataclass(frozen=True)
class SurveyedFloor:
    """A floor and what the localizer knows of it.

    Attributes:
        design: what the floor looks like.
        survey_error: standard deviation of the map's dots along each axis, known to the localizer [m].
        seed: random seed of the floor.
    """

    design: FloorDesign = DARK_ON_LIGHT
    survey_error: float = SURVEY_ERROR
    seed: int = DEMO_FLOOR_SEED

    @cached_property
    def floor(self) -> DotFloor:
        """The true floor."""
        return generate_dot_floor(self.design, self.seed)

    @cached_property
    def localizer(self) -> FloorLocalizer:
        """A localizer with the default settings and the floor's surveyed map."""
        return self.localizer_by(LocalizerSettings.matcher)

    def localizer_by(self, matcher: str) -> FloorLocalizer:
        """Return a localizer with one of the matchers and the floor's surveyed map."""
        dots = survey_floor(self.floor, self.survey_error, self.seed + 1)
        settings = LocalizerSettings(matcher=matcher, map_sigma=self.survey_error)
        return FloorLocalizer(index_map(DotMap(dots[:, :2], dots[:, 2])), MOUNT, settings)

    def places(self, count: int, margin: float = MARGIN) -> Iterator[SE2]:
        """Yield poses that fill the floor, but for a margin, and all headings evenly."""
        for step in np.outer(np.arange(1, count + 1), _EVEN_STEPS) % 1.0:
            x, y = margin + step[:2] * (np.array(self.design.size) - 2.0 * margin)
            yield SE2(float(x), float(y), math.tau * (float(step[2]) - 0.5))

    def outcome(self, images: Iterable[tuple[NDArray[np.uint8], SE2]]) -> Outcome:
        """Locate images taken at true poses."""
        result = Outcome()
        for number, (image, pose) in enumerate(images):
            dots = self.localizer.detect(image)
            result.scores.append(score_pose(self.localizer.locate_dots(dots, CAMERA), pose))
            tracked = self.localizer.locate_dots(dots, CAMERA, tracked_prior(pose, number))
            result.tracked.append(score_pose(tracked, pose))
        return result


def tracked_prior(truth: SE2, number: int) -> PosePrior:
    """Return the predicted pose of a tracked robot: 2 mm and 1 degree from ground truth.

    Args:
        truth: where it is.
        number: index of the image; it sets the direction of the prior's error.
    """
    direction = math.tau * number * _EVEN_STEPS[0]
    turn = PRIOR_TURN if number % 2 else -PRIOR_TURN
    off = SE2(PRIOR_DISTANCE * math.cos(direction), PRIOR_DISTANCE * math.sin(direction), turn)
    tracking = TrackerSettings()
    return PosePrior(truth @ off, tracking.still_radius, tracking.still_turn)
