"""Vignetting by its definition; the glow against eq. (4), written out a second time."""

import math

import numpy as np
import pytest

from scene_simulator.ceiling.lens import SHARP, Blooming, CeilingLens
from scene_simulator.errors import SceneError
from shirube_core.geometry import PinholeCamera


def test_the_glow_follows_equation_4() -> None:
    b, alpha, beta, gamma = 200.0, 2.4, 2.5, 48.0
    blooming = Blooming(alpha, beta, gamma / b)
    for d in np.linspace(0.0, blooming.glow_reach, 50):
        sigma = 1.0 / (1.0 + math.exp(-alpha * (d - beta)))
        expected = (b - gamma) * (1.0 - sigma) + gamma
        assert b * blooming.profile(d) == pytest.approx(expected, abs=1e-9)


def test_inside_a_lamp_is_as_bright_as_its_edge_and_far_away_is_dark() -> None:
    blooming = Blooming()
    inside, outside = blooming.profile([-500.0, -1.0, 0.0]), blooming.profile([blooming.margin, 1e6])
    assert ((inside > 0.99) & (inside <= 1.0)).all()
    assert (outside < 1e-5).all()


@pytest.mark.parametrize('blooming', [SHARP, Blooming(), Blooming(1.0, 4.0, 0.05, 30.0)])
def test_light_only_falls_with_distance_and_without_a_step(blooming: Blooming) -> None:
    light = blooming.profile(np.linspace(-5.0, 70.0, 75_000))
    assert (np.diff(light) <= 1e-15).all()
    assert np.abs(np.diff(light)).max() < 0.26e-3 * blooming.slope


@pytest.mark.parametrize(
    'numbers',
    [
        *((0.0, 2.5, 0.1, 12.0), (3.1, 2.5, 0.1, 12.0), (2.4, -1.0, 0.1, 12.0), (2.4, 2.5, 1.1, 12.0)),
        *((2.4, 2.5, 0.1, 0.0), (float('nan'), 2.5, 0.1, 12.0)),
    ],
)
def test_a_glow_that_pixels_cannot_show_is_refused(numbers: tuple[float, float, float, float]) -> None:
    with pytest.raises(SceneError, match='blooming'):
        Blooming(*numbers)


CAMERA = PinholeCamera(201, 151, 100.0, 100.0, 100.0, 75.0)


def test_light_is_whole_in_the_middle_and_least_in_the_corners() -> None:
    light = CeilingLens(vignetting=0.3).transmission(CAMERA)
    assert light.shape == (151, 201)
    assert light[75, 100] == pytest.approx(1.0)
    np.testing.assert_allclose(light[[0, 0, -1, -1], [0, -1, 0, -1]], 0.7, atol=1e-6)
    assert light[75, 0] == pytest.approx(1.0 - 0.3 * 100.0**2 / (100.0**2 + 75.0**2))
