"""Random-dot floors, such as the paper's vinyl floor (3.1), and their dot maps as a survey gives them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from scene_simulator.errors import SceneError, check_seed
from scene_simulator.floor.marks import FloorMarks, random_chips

Colour = tuple[float, float, float]
_MAX_FILL_FRACTION = 0.4
"""Fraction of the floor that discs of the minimum distance may fill; beyond it redrawing fails."""

SURVEY_ERROR = 0.00005
"""Standard deviation of a surveyed centre along each axis [m]: what careful photogrammetry reaches."""


@dataclass(frozen=True)
class FloorDesign:
    """What a floor looks like. The default is the paper's: black chips of 2 to 3 mm on beige vinyl.

    Attributes:
        size: extent along x and y of the map frame, whose origin is a corner [m].
        count: number of chips.
        diameters: least and greatest diameter of the disc of equal area [m].
        min_distance: centres are never nearer than this; nearer ones would be one chip to any eye [m].
        ground: reflectance of the ground in blue, green and red, 0 to 1.
        chip_colours: colours of the chips, drawn with equal odds.
        colour_spread: standard deviation of a chip's brightness about its colour.
        mottling: standard deviation of the ground's brightness relative to its mean.
    """

    size: tuple[float, float] = (1.8, 9.45)
    count: int = 91_582
    diameters: tuple[float, float] = (0.002, 0.003)
    min_distance: float = 0.0012
    ground: Colour = (0.58, 0.70, 0.76)
    chip_colours: tuple[Colour, ...] = ((0.07, 0.07, 0.07),)
    colour_spread: float = 0.025
    mottling: float = 0.012


DARK_ON_LIGHT = FloorDesign()
LIGHT_ON_DARK = FloorDesign(ground=(0.16, 0.15, 0.14), chip_colours=((0.72, 0.76, 0.78),))
COLOURED = FloorDesign(
    ground=(0.70, 0.72, 0.72),
    chip_colours=((0.10, 0.09, 0.08), (0.55, 0.22, 0.12), (0.15, 0.20, 0.62), (0.18, 0.42, 0.16)),
    colour_spread=0.03,
)


@dataclass(frozen=True)
class DotFloor:
    """A floor and its chips: the truth.

    Attributes:
        design: what the floor looks like.
        chips: the chips; their centres are the area centroids.
        diameters: shape (n,), diameters of the discs of equal area [m].
        seed: seed of the floor, from which its ground takes its mottling.
    """

    design: FloorDesign
    chips: FloorMarks
    diameters: NDArray[np.float64]
    seed: int = field(default=0)

    def __len__(self) -> int:
        """Return the number of chips."""
        return len(self.chips)

    @property
    def points(self) -> NDArray[np.float64]:
        """Area centroids of the chips in the map frame, shape (n, 2) [m]."""
        return self.chips.centres

    def remove_chips(self, fraction: float, seed: int) -> DotFloor:
        """Return the floor without a random fraction (0 to 1) of its chips."""
        kept = np.random.default_rng(seed).uniform(size=len(self)) >= fraction
        return DotFloor(self.design, self.chips.select(kept), self.diameters[kept], self.seed)


def generate_dot_floor(design: FloorDesign, seed: int) -> DotFloor:
    """Generate a floor: chips of random shape, size and orientation at uniformly random positions.

    Some chips touch or overlap, as on a real floor. The same seed gives the same floor.

    Raises:
        SceneError: floor without extent, negative count or seed, or more chips than fit.
    """
    check_seed(seed)
    rng = np.random.default_rng(seed)
    points = _spaced_points(design, rng)
    diameters = rng.uniform(*design.diameters, design.count)
    palette = np.array(design.chip_colours)
    colours = palette[rng.integers(len(palette), size=design.count)]
    colours = colours + rng.normal(0.0, design.colour_spread, (design.count, 1))
    chips = FloorMarks(points, random_chips(diameters, rng), np.clip(colours, 0.0, 1.0), np.ones(design.count))
    return DotFloor(design, chips, diameters, seed)


def _spaced_points(design: FloorDesign, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return random points, shape (n, 2) [m]; of a pair that is too near the later one is redrawn."""
    width, length = design.size
    filled = design.count * math.pi * (0.5 * design.min_distance) ** 2
    if not (0.0 < width < math.inf and 0.0 < length < math.inf and design.count >= 0):
        raise SceneError(f'{design.count} chips on {width} x {length} m is no floor: give a size and number above zero')
    if filled > _MAX_FILL_FRACTION * width * length:
        raise SceneError(
            f'{design.count} chips at least {design.min_distance} m apart do not fit on '
            f'{width} x {length} m: use fewer chips or a larger floor'
        )
    points = rng.uniform((0.0, 0.0), design.size, (design.count, 2))
    while len(pairs := cKDTree(points).query_pairs(design.min_distance, output_type='ndarray')):
        redrawn = np.unique(pairs.max(axis=1))
        points[redrawn] = rng.uniform((0.0, 0.0), design.size, (len(redrawn), 2))
    return points


def survey_floor(floor: DotFloor, error: float, seed: int) -> NDArray[np.float64]:
    """Return a dot map with errors as a survey leaves them, shape (n, 3): x, y in the map frame and diameter [m].

    Chips that touch or overlap are listed one by one. The error is the standard deviation of each number [m]; it is
    refused with a SceneError if it is negative or not finite.
    """
    if not 0.0 <= error < float('inf'):
        raise SceneError(f'the survey error is {error} m: give zero or a positive number')
    true = np.column_stack([floor.points, floor.diameters])
    return np.asarray(true + np.random.default_rng(seed).normal(0.0, error, true.shape))
