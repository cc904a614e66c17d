"""A rendered floor and a drive over it in lanes as a survey source, with ground truth."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.dots import DotMap
from floor_localizer.survey_files.survey_images import Frame
from scene_simulator.floor.camera import FloorCamera
from scene_simulator.floor.dot_floor import DotFloor, FloorDesign, generate_dot_floor
from scene_simulator.robot.leg_drive import LegDrive
from scene_simulator.robot.robot_drive import WheelErrors, simulate_odometry
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

CAMERA = PinholeCamera(320, 320, 260.0, 260.0, 159.5, 159.5)  # view of 160 mm from a height of 130 mm, 0.5 mm per pixel

MOUNT = CameraMount()
VIEW = 0.16
OVERLAP = 0.2
DENSITY = 91_582 / (1.8 * 9.45)
ERRORS = WheelErrors(left_scale=1.02 - 0.0026, right_scale=1.02 + 0.0026)
"""Distances 2 % too long, and a yaw drift of 1 degree per metre."""

_SPEED, _PERIOD, _EVERY = 0.25, 0.02, 16
_EDGE = 0.5 * VIEW


class RenderedSurvey:
    """A square floor and a drive over all of it in lanes."""

    def __init__(self, size: float, seed: int) -> None:
        """Plan the drive over a floor with a side [m]; the seed is that of floor, odometry errors and noise."""
        self._size, self._seed = size, seed
        self.camera = CAMERA
        drive = LegDrive(_lanes(size), [_SPEED] * (2 * _lane_count(size) - 1), 0.05)
        poses = [drive.pose_at(float(time)) for time in np.arange(0.0, drive.duration, _PERIOD)]
        odometry = simulate_odometry(poses, ERRORS, np.random.default_rng([seed, 1]))
        self.truth = poses[::_EVERY]
        self.frames = [Frame(f'image {k}', pose) for k, pose in enumerate(odometry[::_EVERY])]

    @cached_property
    def floor(self) -> DotFloor:
        """The true floor."""
        count = round(DENSITY * self._size**2)
        return generate_dot_floor(FloorDesign(size=(self._size, self._size), count=count), self._seed)

    @property
    def true_map(self) -> DotMap:
        """The true dot map."""
        return DotMap(self.floor.points, self.floor.diameters)

    def batch(self, wanted: Sequence[int]) -> RenderedBatch:
        """Return the wanted images as a batch that any process can render."""
        return RenderedBatch(self._size, self._seed, tuple(wanted))

    def photograph(self, pose: SE2, number: int) -> NDArray[np.uint8]:
        """Return the image taken at a pose."""
        rng = np.random.default_rng([self._seed, 2, number])
        return FloorCamera(CAMERA).photograph(self.floor, [pose], MOUNT, rng=rng).image


@dataclass(frozen=True)
class RenderedBatch:
    """Some images of the drive of a `RenderedSurvey`, by their indices."""

    size: float
    seed: int
    wanted: tuple[int, ...]

    def __iter__(self) -> Iterator[tuple[int, NDArray[np.uint8] | str]]:
        """Render the images."""
        survey = _survey(self.size, self.seed)
        for index in self.wanted:
            yield index, survey.photograph(survey.truth[index], index)


# Each process generates the floor once.
_survey = lru_cache(maxsize=1)(RenderedSurvey)


def _lane_count(size: float) -> int:
    return math.ceil((size - 2.0 * _EDGE) / ((1.0 - OVERLAP) * VIEW)) + 1


def _lanes(size: float) -> list[tuple[float, float]]:
    places = np.linspace(_EDGE, size - _EDGE, _lane_count(size))
    ends = (_EDGE, size - _EDGE)
    return [(ends[(k + far) % 2], float(y)) for k, y in enumerate(places) for far in (0, 1)]
