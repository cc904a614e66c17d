"""Outlines against areas from the textbook."""

from __future__ import annotations

import math

import numpy as np
import pytest

from scene_simulator.lamp_shape import Disc, LampShape, LedGrid, Rectangle


def area(outline: np.ndarray) -> float:
    x, y = outline.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


@pytest.mark.parametrize(
    ('shape', 'expected'),
    [(Disc(0.05), math.pi * 0.05**2), (LedGrid(0.0325), 0.065**2), (Rectangle(0.3, 1.2), 0.36)],
)
def test_outlines_run_counter_clockwise_about_the_area(shape: LampShape, expected: float) -> None:
    assert area(shape.outline()) == pytest.approx(expected, rel=2e-3)
    np.testing.assert_allclose(shape.outline().mean(axis=0), 0.0, atol=1e-12)


@pytest.mark.parametrize('shape', [Disc(0.05), LedGrid(0.0325), Rectangle(0.3, 1.2)])
def test_points_of_reach_hold_the_outline(shape: LampShape) -> None:
    reach, outline = shape.bounding_points(), shape.outline()
    assert (reach.min(axis=0) <= outline.min(axis=0) + 1e-12).all()
    assert (reach.max(axis=0) >= outline.max(axis=0) - 1e-12).all()


def test_the_outermost_leds_end_at_the_radius() -> None:
    grid = LedGrid(0.0325, 0.0025, 8)
    assert 7.0 * grid.pitch + 2.0 * grid.led_radius == pytest.approx(0.065)
