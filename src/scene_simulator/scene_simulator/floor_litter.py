"""Small dirt on a floor: crumbs, dust, hairs, scratches."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scene_simulator.errors import SceneError
from scene_simulator.floor_marks import FloorMarks
from scene_simulator.floor_view import FloorView
from scene_simulator.outlines import random_chips, random_ribbons

_CRUMB_COLOURS = np.array([[0.10, 0.14, 0.18], [0.22, 0.28, 0.34], [0.12, 0.12, 0.12], [0.80, 0.83, 0.84]])
_DUST_COLOURS = np.array([[0.20, 0.22, 0.24], [0.45, 0.48, 0.50]])
_HAIR_COLOURS = np.array([[0.06, 0.08, 0.10], [0.30, 0.42, 0.52]])
_SCRATCH_COLOURS = np.array([[0.85, 0.86, 0.86], [0.35, 0.36, 0.37]])


@dataclass(frozen=True)
class FloorArea:
    """An upright rectangle of the floor in the map frame.

    Attributes:
        low: least x and y [m].
        high: greatest x and y [m].
    """

    low: tuple[float, float]
    high: tuple[float, float]

    def scatter(self, density: float, rng: np.random.Generator) -> NDArray[np.float64]:
        """Return uniformly random points, as many as chance gives at a density [1/m^2], shape (n, 2) [m].

        Raises:
            SceneError: density negative or not finite, or area without extent.
        """
        width, length = self.high[0] - self.low[0], self.high[1] - self.low[1]
        if not (0.0 <= density < math.inf and width > 0.0 and length > 0.0):
            raise SceneError(
                f'cannot scatter {density} per square metre on {width} x {length} m: give positive numbers'
            )
        return rng.uniform(self.low, self.high, (rng.poisson(density * width * length), 2))


@dataclass(frozen=True)
class Litter:
    """Marks that hide the floor.

    Attributes:
        marks: shapes of the litter.
    """

    marks: FloorMarks

    def apply_to(self, view: FloorView) -> None:
        """Paint the marks as dirt."""
        view.paint(self.marks, dirt=True)


def crumbs(area: FloorArea, density: float, seed: int) -> Litter:
    """Return dirt of the size of chips and larger (0.5 to 8 mm), mostly dark: what is mistaken for chips.

    Args:
        area: where.
        density: expected number [1/m^2].
        seed: the same seed scatters the same crumbs.
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
