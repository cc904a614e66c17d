"""The dots of a mat: random, never nearer to each other than the wanted spacing, the same for the same seed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.mat.mat_settings import MatSettings

# Share of a floor that random discs of the least spacing fill before redrawing hardly ends.
_FILLABLE = 0.4
# A map file holds micrometres, and so do the seeds of a mat's parameters.
_MICROMETRES = 1e6
SEED_MAX = 2**32 - 1
"""A seed is an integer from 0 to this."""


@dataclass(frozen=True)
class Mat:
    """A mat whose frame has its origin in the lower left corner, x to the right and y up.

    Attributes:
        settings: what it was made by; width and height are not 0.
        seed: the same seed and settings make the same mat.
        points: shape (n, 2), centres of the dots [m], in whole micrometres.
    """

    settings: MatSettings
    seed: int
    points: NDArray[np.float64]

    @property
    def dot_map(self) -> DotMap:
        """The mat as a map."""
        return DotMap(self.points, np.full(len(self.points), self.settings.diameter))


def lay_mat(settings: MatSettings, seed: int, trial: int = 0) -> Mat:
    """Lay the dots of a mat at random.

    Args:
        settings: what the mat is like, width and height above 0.
        seed: another seed lays entirely other dots, and so do other settings.
        trial: another one lays other dots, too; for a mat that was not unique enough.

    Raises:
        FloorLocalizerError: a seed out of range, dots that would overlap, or more dots than fit.
    """
    _check(settings, seed)
    rng = np.random.default_rng([seed, trial, *_fingerprint(settings)])
    count = round(settings.density * settings.width * settings.height)
    # Dots are not cut by the border of the mat.
    lower = np.full(2, 0.5 * settings.diameter)
    upper = np.array([settings.width, settings.height]) - lower
    points = rng.uniform(lower, upper, (count, 2))
    while len(pairs := cKDTree(points).query_pairs(settings.spacing + 2e-6, output_type='ndarray')):
        redrawn = np.unique(pairs.max(axis=1))
        points[redrawn] = rng.uniform(lower, upper, (len(redrawn), 2))
    return Mat(settings, seed, np.round(points, 6))


def _fingerprint(settings: MatSettings) -> list[int]:
    numbers = (settings.width, settings.height, settings.diameter, settings.spacing)
    return [*(round(_MICROMETRES * number) for number in numbers), round(1000.0 * settings.density)]


def _check(settings: MatSettings, seed: int) -> None:
    if not 0 <= seed <= SEED_MAX:
        raise FloorLocalizerError(f'--seed: {seed} is out of range; give 0 to {SEED_MAX}')
    if settings.spacing <= settings.diameter:
        raise FloorLocalizerError(
            f'--spacing: dots of {1e3 * settings.diameter:g} mm would touch at {1e3 * settings.spacing:g} mm; '
            'give more than the diameter'
        )
    filled = settings.density * math.pi * (0.5 * settings.spacing) ** 2
    if filled > _FILLABLE:
        most = _FILLABLE / (math.pi * (0.5 * settings.spacing) ** 2)
        raise FloorLocalizerError(
            f'--density: {settings.density:g} dots/m² do not fit at a spacing of '
            f'{1e3 * settings.spacing:g} mm; give at most {most:.0f}'
        )
    if settings.density * settings.width * settings.height < 20.0:
        raise FloorLocalizerError(
            f'--density: a mat of {settings.width:g} x {settings.height:g} m has fewer than 20 dots; '
            'print a larger or denser one'
        )
