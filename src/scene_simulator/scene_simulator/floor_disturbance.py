"""Large disturbances of a view: tape, shadow, wet spots, reflections.

Each is a small class with ``disturb(view)``. Tape, shadow and wet spots are fixed to the floor, a reflection
to the camera, whose lamps make it. What hides chips counts as dirt in the view; what only changes the light
does not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scene_simulator.floor_view import FloorView

_BLACK = (0.0, 0.0, 0.0)


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
    """The image of one of the camera's lamps on a glossy floor: it stays at its place in the picture.

    Attributes:
        place: right and down from the middle of the image, -1 to 1.
        radius: standard deviation of the bright spot relative to half the image's width.
        strength: light in its middle, 1 saturates.
    """

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
