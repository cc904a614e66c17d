import numpy as np
import pytest
from lamp_pictures import blinking_rows, draw_lamp, photograph, room

from vlc_beacon.core.lamp_image.row_profile import LampRows, row_profile, rows_from_frame

ROW_TIME, EXPOSURE = 1.89e-5, 6e-5


def test_rows_match_the_waveform():
    rows = blinking_rows(3500.0, ROW_TIME, EXPOSURE)
    picture = draw_lamp(room(level=20.0), (200.3, 150.4), 40.0, 150.0, rows=rows, blur=0.1)
    image = photograph(picture, 1.5, np.random.default_rng(1))
    first, brightness = row_profile(image, np.array([200.3, 150.4]), 40.0, 20.0, 1.5)
    inner = slice(120 - first, 181 - first)
    visible = rows(first + np.arange(len(brightness)))
    assert len(brightness) >= 75
    assert brightness[inner] == pytest.approx(visible[inner], abs=0.12)
    assert np.corrcoef(brightness[inner], visible[inner])[0, 1] > 0.995


@pytest.mark.parametrize('rows', [blinking_rows(3500.0, ROW_TIME, EXPOSURE), None])
@pytest.mark.parametrize('radius', [6.0, 8.0, 15.0])
def test_rows_outside_a_lamp_are_not_dark_bands(radius, rows):
    """Dark rows that are no stripes tell of a tone that nobody plays."""
    for v in np.arange(140.0, 156.0, 2.1):
        picture = draw_lamp(room(), (200.0, v), radius, 200.0, rows=rows)
        first, brightness = row_profile(photograph(picture), np.array([200.0, v]), radius, 4.0)
        assert v - radius - 2.0 <= first <= v - 0.8 * radius
        assert v + 0.8 * radius <= first + len(brightness) - 1 <= v + radius + 2.0


@pytest.mark.parametrize('v', [150.0, 900.0])
def test_a_dark_lamp_and_a_place_outside_have_no_rows(v):
    _, brightness = row_profile(photograph(room()), np.array([200.0, v]), 8.0, 4.0)
    assert len(brightness) == 0


def test_the_middle_is_seen_by_the_middle_row() -> None:
    rows = rows_from_frame(10.0, 100, np.zeros(21), 1e-5, 2e-4)
    assert rows.centre_times == pytest.approx([10.0 + 110 * 1e-5 + 1e-4])


def test_damaged_frames_are_left_out() -> None:
    seen = np.ones((3, 5))
    seen[1, 2] = np.nan
    rows = LampRows(np.array([1.0, 2.0, 3.0]), np.array([4, 5, 6]), seen, 1e-5, 2e-4).drop_invalid_frames()
    assert rows.stamps.tolist() == [1.0, 3.0]
    assert rows.first_rows.tolist() == [4, 6]
    assert rows.brightness.shape == (2, 5)
