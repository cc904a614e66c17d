import numpy as np
import pytest

from vlc_beacon.core.lamp_image.candidates import find_candidates
from vlc_beacon.core.lamp_image.coarse_contrast import CELL
from vlc_beacon.core.lamp_image.settings import LampSettings


def spot(contrast, row, column, level):
    contrast[row : row + 3, column : column + 3] = level
    return contrast


def test_each_spot_is_kept_once_whatever_its_brightness():
    contrast = np.zeros((60, 80), np.uint8)
    levels = (6, 9, 11, 19, 21, 45, 90, 161, 255)
    for k, level in enumerate(levels):
        spot(contrast, 10, 4 + 8 * k, level)
    boxes, peaks = find_candidates(contrast, 5.0, LampSettings())
    assert sorted(peaks) == list(levels)
    assert peaks.tolist() == sorted(peaks, reverse=True)
    assert boxes[-1].tolist() == [4 * CELL, 10 * CELL, 7 * CELL, 13 * CELL]


def test_a_bright_lamp_loses_its_halo():
    contrast = np.zeros((60, 80), np.uint8)
    contrast[20:40, 20:40] = 30
    spot(contrast, 28, 28, 200)
    boxes, peaks = find_candidates(contrast, 5.0, LampSettings())
    assert peaks.tolist() == [200.0]
    assert boxes[0].tolist() == [28 * CELL, 28 * CELL, 31 * CELL, 31 * CELL]


@pytest.mark.parametrize('cells', [1, 30])
def test_spots_of_wrong_size_are_left_out(cells):
    contrast = np.zeros((60, 80), np.uint8)
    contrast[5 : 5 + cells, 5 : 5 + cells] = 80
    settings = LampSettings(diameter_min=10.0, diameter_max=80.0)
    assert len(find_candidates(contrast, 5.0, settings)[0]) == 0


def test_the_brightest_are_taken_where_there_are_many():
    contrast = np.zeros((60, 80), np.uint8)
    for k in range(10):
        spot(contrast, 10, 4 + 7 * k, 100 + k)
    _, peaks = find_candidates(contrast, 5.0, LampSettings(lamps_max=3))
    assert peaks.tolist() == [109.0, 108.0, 107.0]
