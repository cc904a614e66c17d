"""Locate views of the terrazzo without a prior, and compare with where they were cut."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from terrazzo_views import CAMERA, MOUNT, Image, cut_view, terrazzo_map

from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.fix import Fix
from floor_localizer.core.localizer import FloorLocalizer

RIGHT = 0.0005
"""Greatest error of a right pose [m]."""


@dataclass(frozen=True)
class TerrazzoTrial:
    """One view, located.

    Attributes:
        outcome: ``right``, ``none`` or ``wrong``.
        error: position error [m], NaN without a pose.
        turn: error of the heading [rad], NaN without a pose.
        dots: number of dots in the view.
        match_rate: share of the view's dots that were found on the map.
    """

    outcome: str
    error: float
    turn: float
    dots: int
    match_rate: float


class TerrazzoBench:
    """The picture's map, ready to locate views in it."""

    def __init__(self, picture: Image, detector: DotDetector) -> None:
        self._picture = picture
        self._localizer = FloorLocalizer(index_map(terrazzo_map(picture, detector)), MOUNT, None, detector)

    def trial(self, generator: np.random.Generator) -> TerrazzoTrial:
        """Cut a random view and locate it."""
        view = cut_view(self._picture, generator)
        fix = self._localizer.locate(view.image, CAMERA)
        if not isinstance(fix, Fix):
            return TerrazzoTrial('none', np.nan, np.nan, 0 if fix.dots is None else len(fix.dots), np.nan)
        error = fix.T_map_base.distance_to(view.T_map_base)
        turn = view.T_map_base.yaw_to(fix.T_map_base)
        return TerrazzoTrial(
            'right' if error <= RIGHT else 'wrong', error, turn, len(fix.dots), fix.match_rate
        )
