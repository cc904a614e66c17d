"""Mirrors and mains."""

from __future__ import annotations

import numpy as np
import pytest

from scene_simulator.ceiling_lamp import CeilingLamp
from scene_simulator.distractor_lights import distractors, mains_flicker, reflection
from scene_simulator.errors import SceneError
from scene_simulator.lamp_shape import LedGrid
from shirube_core.waveform import waveform_from_steps

HALVES = waveform_from_steps([1e-3, 1e-3], [[1.0, 0.0], [0.0, 1.0]])
LAMP = CeilingLamp((0.4, 1.8, 2.5), LedGrid(), HALVES, 2000.0, rpy=(0.0, 0.0, 0.3))
POINT, NORMAL = np.array([0.0, 3.9, 0.0]), np.array([0.1, -2.0, 0.0])


def test_every_point_of_a_reflection_is_mirrored_at_the_wall() -> None:
    face = np.array([(0.0, 0.0), (0.03, 0.0), (0.0, 0.02), (-0.01, 0.03)])
    mirrored = reflection(LAMP, POINT, NORMAL).map_points(face)
    across = mirrored - LAMP.map_points(face)
    middles = 0.5 * (mirrored + LAMP.map_points(face))
    unit = NORMAL / np.linalg.norm(NORMAL)
    np.testing.assert_allclose(np.cross(across, unit), 0.0, atol=1e-12)
    np.testing.assert_allclose((middles - POINT) @ unit, 0.0, atol=1e-12)


def test_a_reflection_sends_the_same_code_dimmer() -> None:
    mirrored = reflection(LAMP, POINT, NORMAL, 0.25)
    assert mirrored.waveform is LAMP.waveform
    assert mirrored.brightness == pytest.approx(500.0)


def test_two_reflections_are_the_lamp_again() -> None:
    again = reflection(reflection(LAMP, POINT, NORMAL, 1.0), POINT, NORMAL, 1.0)
    np.testing.assert_allclose(again.xyz, LAMP.xyz, atol=1e-12)
    np.testing.assert_allclose(again.map_points([(0.03, 0.01)]), LAMP.map_points([(0.03, 0.01)]), atol=1e-12)


def test_a_mirror_without_direction_is_refused() -> None:
    with pytest.raises(SceneError, match='normal'):
        reflection(LAMP, POINT, (0.0, 0.0, 0.0))


def test_the_mains_flicker_a_hundred_times_a_second() -> None:
    flicker = mains_flicker(100.0, 0.3)
    times = np.linspace(0.0, 0.05, 500)
    levels = flicker.mean_levels(times, times + 1e-4)[:, 0]
    assert flicker.period == pytest.approx(0.01)
    assert levels.max() == pytest.approx(1.0, abs=0.01)
    assert levels.min() == pytest.approx(0.7, abs=0.01)
    assert flicker.mean_levels(0.0, 0.01)[0] == pytest.approx(0.85, abs=1e-6)


def test_no_distractor_hangs_where_a_lamp_of_the_paper_does() -> None:
    places = np.array([light.xyz for light in distractors()])
    assert len(places) == 4
    assert np.hypot(places[:, 0] % 1.8, places[:, 1] % 1.8).min() > 0.2
