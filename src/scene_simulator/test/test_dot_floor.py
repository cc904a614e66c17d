"""The floor's density, spacing and seed."""

import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from scene_simulator.errors import SceneError
from scene_simulator.floor.dot_floor import DARK_ON_LIGHT, FloorDesign, generate_dot_floor, survey_floor

FLOOR = generate_dot_floor(DARK_ON_LIGHT, 3)


def test_the_default_floor_has_the_density_and_the_diameters_of_the_paper() -> None:
    assert len(FLOOR) == 91_582
    assert FLOOR.points.min() >= 0.0
    assert (FLOOR.points <= (1.8, 9.45)).all()
    views, _, _ = np.histogram2d(*FLOOR.points.T, bins=(20, 105))
    assert views.mean() == pytest.approx(43.6, abs=0.1)
    assert views.var() == pytest.approx(views.mean(), rel=0.1)
    assert ((FLOOR.diameters >= 0.002) & (FLOOR.diameters <= 0.003)).all()


def test_chips_keep_their_least_distance_and_some_touch() -> None:
    nearest = cKDTree(FLOOR.points).query(FLOOR.points, k=2)[0][:, 1]
    assert nearest.min() > 0.0012
    touching = float((nearest < 0.0025).mean())
    expected = 1.0 - math.exp(-5384.0 * math.pi * (0.0025**2 - 0.0012**2))
    assert touching == pytest.approx(expected, rel=0.05)


def test_a_disc_holds_the_chips_that_reach_into_it() -> None:
    point, radius = (0.9, 4.0), 0.05
    found = FLOOR.chips.near(point, radius)
    corners = FLOOR.chips.corners() - point
    reaching = np.flatnonzero((np.hypot(corners[..., 0], corners[..., 1]) < radius).any(axis=1))
    assert np.isin(reaching, found).all()
    assert len(found) < 1.3 * len(reaching)


def test_wear_removes_its_fraction() -> None:
    remove_chips = FLOOR.remove_chips(0.1, 4)
    assert len(remove_chips) == pytest.approx(0.9 * len(FLOOR), rel=0.01)
    assert len(remove_chips.diameters) == len(remove_chips)
    assert np.isin(remove_chips.points[:, 0], FLOOR.points[:, 0]).all()


@pytest.mark.parametrize(
    ('design', 'seed', 'complaint'),
    [
        (FloorDesign(size=(0.1, 0.1)), 1, 'do not fit'),
        (FloorDesign(count=-1), 1, 'no floor'),
        (FloorDesign(size=(math.nan, 1.0)), 1, 'no floor'),
        (FloorDesign(size=(math.inf, 1.0)), 1, 'no floor'),
        (DARK_ON_LIGHT, -1, 'seed'),
    ],
)
def test_impossible_floors_are_refused(design: FloorDesign, seed: int, complaint: str) -> None:
    with pytest.raises(SceneError, match=complaint):
        generate_dot_floor(design, seed)


def test_the_survey_is_off_by_its_error() -> None:
    errors = survey_floor(FLOOR, 0.00005, 1) - np.column_stack([FLOOR.points, FLOOR.diameters])
    np.testing.assert_allclose(errors.std(axis=0), 0.00005, rtol=0.06)
    assert np.abs(errors.mean(axis=0)).max() < 0.000005
    with pytest.raises(SceneError, match='survey error'):
        survey_floor(FLOOR, -1.0, 1)
