"""Disturbances of a view: crumbs, dust, hairs, scratches, tape, shadow, wet spots, reflections.

Each is a small class with ``apply_to(view)``. A reflection is fixed to the camera, whose lamps make it, all others
to the floor. What hides chips counts as dirt in the view; what only changes the light does not.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scene_simulator.errors import SceneError
from scene_simulator.floor.dot_floor import FloorMarks, random_chips, random_ribbons
from scene_simulator.floor.view import FloorView

_CRUMB_COLOURS = np.array([[0.10, 0.14, 0.18], [0.22, 0.28, 0.34], [0.12, 0.12, 0.12], [0.80, 0.83, 0.84]])
_DUST_COLOURS = np.array([[0.20, 0.22, 0.24], [0.45, 0.48, 0.50]])
_HAIR_COLOURS = np.array([[0.06, 0.08, 0.10], [0.30, 0.42, 0.52]])
_SCRATCH_COLOURS = np.array([[0.85, 0.86, 0.86], [0.35, 0.36, 0.37]])
_BLACK = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class FloorArea:
    """An upright rectangle of the floor: least and greatest x and y in the map frame [m]."""

    low: tuple[float, float]
    high: tuple[float, float]

    def scatter(self, density: float, rng: np.random.Generator) -> NDArray[np.float64]:
        """Return uniformly random points, shape (n, 2) [m], of a density [1/m^2], or raise SceneError."""
        width, length = self.high[0] - self.low[0], self.high[1] - self.low[1]
        if not (0.0 <= density < math.inf and width > 0.0 and length > 0.0):
            raise SceneError(
                f'cannot scatter {density} per square metre on {width} x {length} m: give positive numbers'
            )
        return rng.uniform(self.low, self.high, (rng.poisson(density * width * length), 2))


@dataclass(frozen=True)
class Litter:
    """Marks that hide the floor."""

    marks: FloorMarks

    def apply_to(self, view: FloorView) -> None:
        """Paint the marks as dirt."""
        view.paint(self.marks, dirt=True)


def crumbs(area: FloorArea, density: float, seed: int) -> Litter:
    """Return dirt of the size of chips and larger (0.5 to 8 mm), mostly dark: what is mistaken for chips.

    The density is the expected number [1/m^2]; the same seed scatters the same crumbs.
    """
    rng = np.random.default_rng(seed)
    centres = area.scatter(density, rng)
    diameters = np.clip(rng.lognormal(math.log(0.0016), 0.6, len(centres)), 0.0005, 0.008)
    outlines = random_chips(diameters, rng, corners=(9, 14), roughness=0.45, elongation=2.5)
    return _litter(centres, outlines, _CRUMB_COLOURS, (0.6, 1.0), rng)


def dust(area: FloorArea, density: float, seed: int) -> Litter:
    """Return specks of 0.1 to 0.5 mm, each about a pixel; arguments as for ``crumbs``."""
    rng = np.random.default_rng(seed)
    centres = area.scatter(density, rng)
    outlines = random_chips(rng.uniform(0.0001, 0.0005, len(centres)), rng, corners=(4, 6))
    return _litter(centres, outlines, _DUST_COLOURS, (0.3, 0.9), rng)


def hairs(area: FloorArea, density: float, seed: int) -> Litter:
    """Return hairs and fibres, 10 to 60 mm long and 0.06 to 0.12 mm thick; arguments as for ``crumbs``."""
    rng = np.random.default_rng(seed)
    centres = area.scatter(density, rng)
    lengths = rng.uniform(0.01, 0.06, len(centres))
    widths = rng.uniform(0.00006, 0.00012, len(centres))
    outlines = random_ribbons(lengths, widths, 3.0, rng)
    return _litter(centres, outlines, _HAIR_COLOURS, (0.8, 1.0), rng)


def scratches(area: FloorArea, density: float, seed: int) -> Litter:
    """Return nearly straight scratches, 10 to 60 mm long, 0.1 to 0.3 mm wide; arguments as for ``crumbs``."""
    rng = np.random.default_rng(seed)
    centres = area.scatter(density, rng)
    lengths = rng.uniform(0.01, 0.06, len(centres))
    outlines = random_ribbons(lengths, rng.uniform(0.0001, 0.0003, len(centres)), 0.15, rng)
    return _litter(centres, outlines, _SCRATCH_COLOURS, (0.3, 0.7), rng)


def _litter(
    centres: NDArray[np.float64],
    outlines: NDArray[np.float64],
    palette: NDArray[np.float64],
    opacities: tuple[float, float],
    rng: np.random.Generator,
) -> Litter:
    """Return litter of random colours of a palette, shape (k, 3), and random opacities of a range."""
    n = len(centres)
    colours = palette[rng.integers(len(palette), size=n)] * rng.uniform(0.8, 1.2, (n, 1))
    return Litter(FloorMarks(centres, outlines, np.clip(colours, 0.0, 1.0), rng.uniform(*opacities, n)))


@dataclass(frozen=True)
class Tape:
    """An opaque straight band: a marking line, or, made wide, a mat that covers half the view.

    Attributes:
        start: middle of one end in the map frame [m].
        end: middle of the other end [m].
        width: full width [m].
        colour: reflectance in blue, green and red.
    """

    start: tuple[float, float]
    end: tuple[float, float]
    width: float
    colour: tuple[float, float, float] = (0.88, 0.90, 0.90)

    def apply_to(self, view: FloorView) -> None:
        """Cover the floor with the band."""
        dx, dy = self.end[0] - self.start[0], self.end[1] - self.start[1]
        length = math.hypot(dx, dy)
        from_start = view.floor_points - self.start
        along = (from_start @ (dx, dy)) / length
        across = (from_start @ (-dy, dx)) / length
        inside = np.minimum(0.5 * length - np.abs(along - 0.5 * length), 0.5 * self.width - np.abs(across))
        view.blend(_ramp(inside, view.pixel_size), self.colour, dirt=True)


@dataclass(frozen=True)
class ShadowEdge:
    """A straight shadow edge.

    Attributes:
        point: a point of the edge in the map frame [m].
        direction: direction from the light into the shadow, counter-clockwise from the map's x [rad].
        depth: fraction of the light that the shadow takes.
        penumbra: width over which the light fades [m].
    """

    point: tuple[float, float]
    direction: float
    depth: float = 0.5
    penumbra: float = 0.006

    def apply_to(self, view: FloorView) -> None:
        """Darken the floor beyond the edge."""
        normal = (math.cos(self.direction), math.sin(self.direction))
        beyond = (view.floor_points - self.point) @ normal
        view.blend(self.depth * _ramp(beyond, self.penumbra), _BLACK, dirt=False)


@dataclass(frozen=True)
class WetSpot:
    """A puddle that darkens the floor, most at its rim, and mirrors a lamp; its curved rim may mirror it, too.

    Attributes:
        centre: middle in the map frame [m].
        radius: mean radius [m].
        depth: fraction of the light that the water takes.
        shine: strength of the mirrored lamp, 1 saturates.
        seed: seed of its outline.
        rim_shine: strength of the lamp in the rim, 1 saturates; brightest where the rim faces map's x.
    """

    centre: tuple[float, float]
    radius: float = 0.03
    depth: float = 0.25
    shine: float = 0.9
    seed: int = 0
    rim_shine: float = 0.0

    def apply_to(self, view: FloorView) -> None:
        """Darken the floor under the water and add the mirrored lamp."""
        if math.dist(self.centre, view.centre) > view.reach + 2.0 * self.radius:
            return
        offset = view.floor_points - self.centre
        distance = np.hypot(offset[..., 0], offset[..., 1])
        bearing = np.arctan2(offset[..., 1], offset[..., 0])
        inside = self._edge(bearing) - distance
        rim = np.exp(-np.square(inside / 0.0015))
        view.blend(self.depth * (_ramp(inside, 0.0015) + 0.5 * rim), _BLACK, dirt=False)
        crescent = np.exp(-0.5 * np.square((distance - 0.4 * self.radius) / (0.05 * self.radius)))
        facing = 0.5 + 0.5 * np.cos(bearing)
        view.add_glare(self.shine * crescent * np.square(facing) ** 2 + self.rim_shine * rim * facing)

    def _edge(self, angles: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the outline's radius [m] in directions [rad]."""
        rng = np.random.default_rng(self.seed)
        swell = np.zeros_like(angles)
        for wave in (2, 3, 5):
            swell += rng.uniform(0.05, 0.3) / wave * np.cos(wave * angles + rng.uniform(0.0, math.tau))
        return np.asarray(self.radius * (1.0 + swell))


@dataclass(frozen=True)
class SpecularReflection:
    """A lamp's image, fixed in the picture: place right and down, -1 to 1, radius in half widths, strength."""

    place: tuple[float, float]
    radius: float = 0.06
    strength: float = 1.2

    def apply_to(self, view: FloorView) -> None:
        """Add the lamp's light."""
        height, width = view.glare.shape
        right = (np.arange(width) - 0.5 * (width - 1)) / (0.5 * width) - self.place[0]
        down = (np.arange(height) - 0.5 * (height - 1)) / (0.5 * width) - self.place[1]
        squares = np.square(right)[None, :] + np.square(down)[:, None]
        view.add_glare(self.strength * np.exp(-0.5 * squares / self.radius**2))


def _ramp(distance: NDArray[np.float64], width: float) -> NDArray[np.float64]:
    """Return 0 outside (negative distance) and 1 inside, with a straight ramp of this width between."""
    return np.clip(0.5 + distance / width, 0.0, 1.0)
