"""Wrong merges of a survey, and localization accuracy on its map."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from _surveyed_floor import CAMERA, MOUNT, RenderedSurvey
from numpy.typing import NDArray

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dots import DotMap
from floor_localizer.core.fix import Fix
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.survey.adjustment.observations import project_rays_to_map
from floor_localizer.survey_files.survey_run import SurveyRun
from shirube_core.geometry import SE2

_SAME_PLACE = 0.0015
_EDGE = 0.15
_STEP = SE2(0.05, 0.0, 0.0)


@dataclass(frozen=True)
class PoseScores:
    """Poses on a map against the ground truth.

    Attributes:
        tried: number of images.
        errors: position errors of the located images, shape (k,) [m].
        turns: yaw errors of the located images, shape (k,) [rad].
        match_rates: match rates, shape (k,).
        step_errors: errors of the motion between two images 50 mm apart, shape (j,) [m].
    """

    tried: int
    errors: NDArray[np.float64]
    turns: NDArray[np.float64]
    match_rates: NDArray[np.float64]
    step_errors: NDArray[np.float64]


def wrong_merges(run: SurveyRun, survey: RenderedSurvey) -> tuple[int, int]:
    """Return the number of dots merged from observations of different true dots, and the number of all dots."""
    numbers = [int(run.images.frames[k].name.split()[1]) for k in run.result.images]
    poses = np.array([(p.x, p.y, p.yaw, 0.0, 0.0, 0.0) for p in (survey.truth[k] for k in numbers)])
    wrong = dots = 0
    for block in run.result.blocks:
        observations = block.observations
        true = project_rays_to_map(observations.directions, np.array(MOUNT.xyz), poses[observations.image])
        count = np.maximum(np.bincount(observations.dot), 1)
        means = np.column_stack([np.bincount(observations.dot, true[:, k]) / count for k in range(2)])
        far = np.hypot(*(true - means[observations.dot]).T) > _SAME_PLACE
        wrong += len(np.unique(observations.dot[far]))
        dots += len(np.unique(observations.dot))
    return wrong, dots


def locate_on(survey: RenderedSurvey, dot_map: DotMap, T_true_map: SE2 | None, places: int) -> PoseScores:
    """Locate rendered images, two at each place, without a prior.

    Args:
        survey: rendered floor.
        dot_map: map to localize on.
        T_true_map: pose of its frame in the true frame, None for the true map.
        places: number of random positions, at a distance from the border.
    """
    localizer, rng = FloorLocalizer(index_map(dot_map), MOUNT), np.random.default_rng(11)
    T_true_map = T_true_map or SE2(0.0, 0.0, 0.0)
    size = survey.floor.design.size
    errors, turns, rates, steps = [], [], [], []
    for number in range(places):
        x, y = rng.uniform(_EDGE, np.array(size) - _EDGE)
        start = SE2(float(x), float(y), float(rng.uniform(-math.pi, math.pi)))
        found = []
        for k, pose in enumerate((start, start @ _STEP)):
            fix = localizer.locate(survey.photograph(pose, 100_000 + 2 * number + k, 0.0), CAMERA)
            if isinstance(fix, Fix):
                placed = T_true_map @ fix.T_map_base
                found.append(placed)
                errors.append(placed.distance_to(pose))
                turns.append(abs(placed.yaw_to(pose)))
                rates.append(fix.match_rate)
        if len(found) == 2:
            steps.append((found[0].inverse() @ found[1]).distance_to(_STEP))
    return PoseScores(2 * places, np.array(errors), np.array(turns), np.array(rates), np.array(steps))
