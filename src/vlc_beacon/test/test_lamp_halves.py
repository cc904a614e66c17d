import math

import numpy as np
import pytest
from lamp_pictures import draw_lamp, photograph, room

from vlc_beacon.core.lamp_image.lamp_halves import (
    HALF_DISC_CENTROID,
    SplitAxis,
    half_levels,
    intensity_centroid,
)

MIDDLE, RADIUS, BACKGROUND = np.array([200.3, 150.6]), 12.0, 10.0


def image_of(halves, angle):
    picture = draw_lamp(room(level=BACKGROUND), MIDDLE, RADIUS, 150.0, halves=halves, angle=angle)
    return photograph(picture)


@pytest.mark.parametrize('angle', [0.0, 0.7, 2.5])
@pytest.mark.parametrize('halves', [(1.0, 1.0), (1.0, 0.0), (0.3, 0.9)])
def test_levels_and_centroid_of_halves_are_as_drawn(angle, halves):
    image, axis = image_of(halves, angle), np.array([math.cos(angle), math.sin(angle)])
    levels = half_levels(image, MIDDLE, RADIUS, axis, BACKGROUND)
    assert levels == pytest.approx([150.0 * halves[0], 150.0 * halves[1]], abs=2.0)
    lean = (halves[0] - halves[1]) / (halves[0] + halves[1])
    centroid = intensity_centroid(image, MIDDLE, RADIUS, BACKGROUND)
    assert centroid - MIDDLE == pytest.approx(lean * HALF_DISC_CENTROID * RADIUS * axis, abs=0.1)


def test_a_dark_lamp_keeps_its_place():
    assert intensity_centroid(np.zeros((300, 400), np.uint8), MIDDLE, RADIUS, 0.0) == pytest.approx(MIDDLE)


def test_jumps_determine_the_axis_with_constant_sign():
    rng = np.random.default_rng(1)
    split = SplitAxis()
    for k in range(200):
        angle = 0.02 * k
        line = np.array([math.cos(angle), math.sin(angle)])
        split.add(rng.choice([-1.0, 0.0, 1.0]) * 0.42 * RADIUS * line + 0.1 * rng.normal(size=2), RADIUS)
        if k == 20:
            sign = np.sign(split.axis @ line)
        if k >= 20:
            assert split.is_split
            assert sign * (split.axis @ line) > 0.9


def test_a_lamp_that_does_not_jump_is_not_split():
    rng = np.random.default_rng(2)
    split = SplitAxis()
    for _ in range(200):
        split.add(0.3 * rng.normal(size=2), RADIUS)
    assert not split.is_split
    assert split.split_uncertainty == 0.0


def test_a_known_rotation_rotates_the_axis():
    split = SplitAxis()
    for k in range(20):
        split.add(np.array([0.4 * RADIUS * (-1) ** k, 0.0]), RADIUS)
    before = split.axis.copy()
    split.rotate(0.5)
    assert math.atan2(*split.axis[::-1]) - math.atan2(*before[::-1]) == pytest.approx(0.5)
