"""The lamp's clock and place."""

from __future__ import annotations

import math

import numpy as np
import pytest

from scene_simulator.ceiling_lamp import CeilingLamp
from scene_simulator.errors import SceneError
from shirube_core.waveform import waveform_from_steps

BLINK = waveform_from_steps([1e-3, 1e-3], [1.0, 0.0])


def test_phase_shifts_the_waveform() -> None:
    lamp = CeilingLamp((0.0, 0.0, 2.5), waveform=BLINK, phase=0.25e-3)
    np.testing.assert_allclose(lamp.mean_levels([0.70e-3, 0.80e-3], [0.74e-3, 0.84e-3]), [[1.0], [0.0]])


def test_a_clock_that_is_100_ppm_fast_is_half_a_millisecond_ahead_after_five_seconds() -> None:
    fast = CeilingLamp((0.0, 0.0, 2.5), waveform=BLINK, clock_offset=100.0)
    exact = CeilingLamp((0.0, 0.0, 2.5), waveform=BLINK)
    starts = 5.0 + np.linspace(0.0, 2e-3, 20, endpoint=False) + 1e-6
    fast_levels = fast.mean_levels(starts, starts + 1e-5)
    np.testing.assert_allclose(
        fast_levels, exact.mean_levels(starts + 0.5e-3, starts + 0.5e-3 + 1e-5), atol=1e-3
    )


def test_the_face_turns_about_its_middle() -> None:
    lamp = CeilingLamp((1.0, 2.0, 2.5), rpy=(math.pi / 2.0, 0.0, 0.0))
    points = lamp.map_points([(0.0, 0.0), (0.1, 0.0), (0.0, 0.1)])
    np.testing.assert_allclose(points, [(1.0, 2.0, 2.5), (1.1, 2.0, 2.5), (1.0, 2.0, 2.6)], atol=1e-12)


def test_a_lamp_that_cannot_be_is_refused() -> None:
    with pytest.raises(SceneError, match='brightness'):
        CeilingLamp((0.0, 0.0, 2.5), brightness=-1.0)
    with pytest.raises(SceneError, match='finite'):
        CeilingLamp((0.0, float('nan'), 2.5))
