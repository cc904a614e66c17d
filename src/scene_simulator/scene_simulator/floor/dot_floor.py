"""Random-dot floors, such as the paper's vinyl floor (3.1), and their dot maps as a survey gives them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from scene_simulator.errors import SceneError, check_seed


@dataclass(frozen=True)
class FloorMarks:
    """Polygons on the floor, in the map frame.

    Attributes:
        centres: shape (n, 2), reference points [m].
        outlines: shape (n, v, 2), corners relative to the reference points [m].
        colours: shape (n, 3), reflectance in blue, green and red, 0 to 1.
        opacities: shape (n,), fraction of the ground's light that a mark hides, 0 to 1.
    """

    centres: NDArray[np.float64]
    outlines: NDArray[np.float64]
    colours: NDArray[np.float64]
    opacities: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of marks."""
        return len(self.centres)

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self.centres)

    @cached_property
    def _reach(self) -> float:
        """Distance of the farthest corner from its reference point [m]."""
        return float(np.hypot(self.outlines[..., 0], self.outlines[..., 1]).max(initial=0.0))

    def near(self, point: ArrayLike, radius: float) -> NDArray[np.int64]:
        """Return which marks may reach into a disc about a point, shape (2,): ascending indices, shape (k,)."""
        if len(self) == 0:
            return np.empty(0, dtype=np.int64)
        found = self._tree.query_ball_point(np.asarray(point, dtype=np.float64), radius + self._reach)
        return np.sort(np.asarray(found, dtype=np.int64))

    def select(self, indices: NDArray[np.int64] | NDArray[np.bool_]) -> FloorMarks:
        """Return the marks with these indices (or where the mask is true)."""
        return FloorMarks(self.centres[indices], self.outlines[indices], self.colours[indices], self.opacities[indices])

    def corners(self) -> NDArray[np.float64]:
        """Return all corners in the map frame, shape (n, v, 2) [m]."""
        return np.asarray(self.centres[:, None] + self.outlines)


def polygon_areas(outlines: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the signed areas of polygons, shape (n, v, 2) to (n,), positive when counter-clockwise [m^2]."""
    following = np.roll(outlines, -1, axis=1)
    return 0.5 * _cross(outlines, following).sum(axis=1)


def polygon_centroids(outlines: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the area centroids of polygons, shape (n, v, 2) to (n, 2) [m]."""
    following = np.roll(outlines, -1, axis=1)
    moments = ((outlines + following) * _cross(outlines, following)[..., None]).sum(axis=1)
    return np.asarray(moments / (6.0 * polygon_areas(outlines))[:, None])


def random_chips(
    diameters: NDArray[np.float64],
    rng: np.random.Generator,
    *,
    corners: tuple[int, int] = (5, 8),
    roughness: float = 0.2,
    elongation: float = 1.5,
) -> NDArray[np.float64]:
    """Return irregular, nearly convex polygons as crushed plastic leaves them.

    Corners are at uneven steps around an ellipse and are pushed inwards at random; then each polygon is
    turned at random, moved to have its area centroid at the origin and scaled to its area.

    Args:
        diameters: shape (n,), diameters of the discs of equal area [m].
        rng: source of randomness.
        corners: least and greatest number of corners.
        roughness: largest fraction of the radius by which a corner is pushed inwards.
        elongation: greatest ratio of length to width.

    Returns:
        array, shape (n, corners[1], 2), counter-clockwise corners about the area centroid [m].
    """
    n, most = len(diameters), corners[1]
    counts = rng.integers(corners[0], most + 1, size=(n, 1))
    places = np.minimum(np.arange(most), counts - 1)
    steps = np.take_along_axis(rng.uniform(0.0, 0.8, (n, most)), places, axis=1)
    radii = np.take_along_axis(rng.uniform(1.0 - roughness, 1.0, (n, most)), places, axis=1)
    angles = math.tau * (places + steps) / counts
    stretch = np.sqrt(rng.uniform(1.0, elongation, (n, 1)))
    outlines = np.stack([radii * np.cos(angles) * stretch, radii * np.sin(angles) / stretch], axis=-1)
    outlines = _rotate(outlines, rng.uniform(0.0, math.tau, n))
    outlines -= polygon_centroids(outlines)[:, None]
    scale = 0.5 * diameters * np.sqrt(math.pi / polygon_areas(outlines))
    return np.asarray(outlines * scale[:, None, None])


def random_ribbons(
    lengths: NDArray[np.float64],
    widths: NDArray[np.float64],
    bend: float,
    rng: np.random.Generator,
    *,
    joints: int = 24,
) -> NDArray[np.float64]:
    """Return thin, randomly bent bands: hairs (much bend) or scratches (little).

    Args:
        lengths: shape (n,), lengths along the middle line [m].
        widths: shape (n,), full widths [m].
        bend: standard deviation of the whole turn from one end to the other [rad].
        rng: source of randomness.
        joints: number of points along the middle line.

    Returns:
        array, shape (n, 2 * joints, 2), corners about the mean of the middle line [m].
    """
    n = len(lengths)
    curvature = np.cumsum(rng.normal(size=(n, joints)), axis=1) / math.sqrt(joints)
    headings = np.cumsum(rng.normal(size=(n, 1)) + curvature, axis=1) * (bend / joints)
    headings += rng.uniform(0.0, math.tau, (n, 1))
    tangents = np.stack([np.cos(headings), np.sin(headings)], axis=-1)
    middle = np.cumsum(tangents, axis=1) * (lengths / joints)[:, None, None]
    middle -= middle.mean(axis=1, keepdims=True)
    sideways = np.stack([-tangents[..., 1], tangents[..., 0]], axis=-1) * (0.5 * widths)[:, None, None]
    return np.concatenate([middle - sideways, (middle + sideways)[:, ::-1]], axis=1)


def _cross(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the z components of cross products of plane vectors, shape (..., 2) to (...)."""
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])


def _rotate(outlines: NDArray[np.float64], angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return each outline turned about the origin by its angle [rad]."""
    cos, sin = np.cos(angles)[:, None], np.sin(angles)[:, None]
    x, y = outlines[..., 0], outlines[..., 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)


Colour = tuple[float, float, float]
_MAX_FILL_FRACTION = 0.4  # fraction of the floor that discs of the minimum distance may fill; beyond it redrawing fails
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
