"""Outlines against areas from the textbook; the lamp's clock and place."""

import math

import numpy as np
import pytest

from scene_simulator.ceiling.lamp import CeilingLamp, Disc, LampShape, LedGrid, Rectangle
from scene_simulator.errors import SceneError
from shirube_core.waveform import waveform_from_steps


def area(outline: np.ndarray) -> float:
    x, y = outline.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


@pytest.mark.parametrize(
    ('shape', 'expected'), [(Disc(0.05), math.pi * 0.05**2), (LedGrid(0.0325), 0.065**2), (Rectangle(0.3, 1.2), 0.36)]
)
def test_outlines_run_counter_clockwise_about_the_area(shape: LampShape, expected: float) -> None:
    assert area(shape.outline()) == pytest.approx(expected, rel=2e-3)
    np.testing.assert_allclose(shape.outline().mean(axis=0), 0.0, atol=1e-12)
    reach, outline = shape.bounding_points(), shape.outline()
    assert (reach.min(axis=0) <= outline.min(axis=0) + 1e-12).all()
    assert (reach.max(axis=0) >= outline.max(axis=0) - 1e-12).all()


def test_the_outermost_leds_end_at_the_radius() -> None:
    grid = LedGrid(0.0325, 0.0025, 8)
    assert 7.0 * grid.pitch + 2.0 * grid.led_radius == pytest.approx(0.065)


@pytest.mark.parametrize(
    ('clock', 'ahead'),
    [({'phase': 0.25e-3}, 0.25e-3), ({'clock_offset': 100.0}, 0.5e-3)],  # 100 ppm fast, after five seconds
)
def test_phase_and_clock_shift_the_waveform(clock: dict[str, float], ahead: float) -> None:
    blink = waveform_from_steps([1e-3, 1e-3], [1.0, 0.0])
    shifted, exact = (CeilingLamp((0.0, 0.0, 2.5), waveform=blink, **given) for given in (clock, {}))
    starts = 5.0 + np.linspace(0.0, 2e-3, 20, endpoint=False) + 1e-6
    levels = exact.mean_levels(starts + ahead, starts + ahead + 1e-5)
    np.testing.assert_allclose(shifted.mean_levels(starts, starts + 1e-5), levels, atol=1e-3)


def test_the_face_turns_about_its_middle() -> None:
    lamp = CeilingLamp((1.0, 2.0, 2.5), rpy=(math.pi / 2.0, 0.0, 0.0))
    points = lamp.map_points([(0.0, 0.0), (0.1, 0.0), (0.0, 0.1)])
    np.testing.assert_allclose(points, [(1.0, 2.0, 2.5), (1.1, 2.0, 2.5), (1.0, 2.0, 2.6)], atol=1e-12)


@pytest.mark.parametrize(('y', 'brightness', 'words'), [(0.0, -1.0, 'brightness'), (math.nan, 1.0, 'finite')])
def test_a_lamp_that_cannot_be_is_refused(y: float, brightness: float, words: str) -> None:
    with pytest.raises(SceneError, match=words):
        CeilingLamp((0.0, y, 2.5), brightness=brightness)
