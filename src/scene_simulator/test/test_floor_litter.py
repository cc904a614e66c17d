"""How much litter there is, of what size, and that it is counted as dirt."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from scene_simulator.dot_floor import FloorDesign, generate_dot_floor
from scene_simulator.errors import SceneError
from scene_simulator.floor_camera import FloorCamera
from scene_simulator.floor_litter import FloorArea, Litter, crumbs, dust, hairs, scratches
from scene_simulator.outlines import polygon_areas
from shirube_core.geometry import SE2

AREA = FloorArea((0.1, 0.2), (2.1, 1.2))
Scatter = Callable[[FloorArea, float, int], Litter]
KINDS: list[Scatter] = [crumbs, dust, hairs, scratches]


@pytest.mark.parametrize('kind', KINDS)
def test_litter_has_its_density_in_its_area(kind: Scatter) -> None:
    marks = kind(AREA, 800.0, 1).marks
    assert len(marks) == pytest.approx(1600, abs=5 * math.sqrt(1600))
    assert (marks.centres >= AREA.low).all()
    assert (marks.centres <= AREA.high).all()
    assert marks.colours.min() >= 0.0
    assert marks.colours.max() <= 1.0
    assert marks.opacities.max() <= 1.0


@pytest.mark.parametrize('kind', KINDS)
def test_the_same_seed_scatters_the_same(kind: Scatter) -> None:
    first, again, other = (kind(AREA, 50.0, seed).marks.centres for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_dirt_in_the_picture_has_the_area_of_the_crumbs() -> None:
    floor = generate_dot_floor(FloorDesign(size=(0.4, 0.4), count=0), 1)
    litter = crumbs(FloorArea((0.18, 0.18), (0.22, 0.22)), 12_000.0, 3)
    photo = FloorCamera().photograph(floor, [SE2(0.2, 0.2, 0.0)], disturbances=[litter])
    hidden = photo.dirt.sum() * (0.13 / 339.44) ** 2
    upper = (polygon_areas(litter.marks.outlines) * litter.marks.opacities).sum()
    assert 0.8 * upper < hidden <= 1.001 * upper


@pytest.mark.parametrize('density', [-1.0, math.nan, math.inf])
def test_impossible_densities_are_refused(density: float) -> None:
    with pytest.raises(SceneError, match='scatter'):
        dust(AREA, density, 1)
