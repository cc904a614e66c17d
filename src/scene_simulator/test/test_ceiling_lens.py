"""Vignetting and lens flare by their definitions."""

from __future__ import annotations

import numpy as np
import pytest

from scene_simulator.blooming import Blooming
from scene_simulator.ceiling_lens import CeilingLens, LensFlare
from shirube_core.geometry import PinholeCamera

CAMERA = PinholeCamera(201, 151, 100.0, 100.0, 100.0, 75.0)


def test_light_is_whole_in_the_middle_and_least_in_the_corners() -> None:
    light = CeilingLens(vignetting=0.3).transmission(CAMERA)
    assert light.shape == (151, 201)
    assert light[75, 100] == pytest.approx(1.0)
    np.testing.assert_allclose(light[[0, 0, -1, -1], [0, -1, 0, -1]], 0.7, atol=1e-6)
    assert light[75, 0] == pytest.approx(1.0 - 0.3 * 100.0**2 / (100.0**2 + 75.0**2))


def test_a_lens_without_vignetting_passes_all_light() -> None:
    assert (CeilingLens(vignetting=0.0).transmission(CAMERA) == 1.0).all()


def test_defocus_widens_the_reach_of_a_lamp() -> None:
    assert CeilingLens(defocus=2.0).margin == pytest.approx(Blooming().margin + 8.0)


def test_a_flare_is_half_as_bright_at_its_radius_and_zero_at_its_margin() -> None:
    flare = LensFlare(strength=0.04, radius=9.0)
    bright, half, gone = flare.profile(np.array([0.0, 9.0, flare.margin]))
    assert bright == pytest.approx(0.04, rel=1e-3)
    assert half == pytest.approx(0.02)
    assert gone < 1e-6
