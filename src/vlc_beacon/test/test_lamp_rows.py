import numpy as np
import pytest

from vlc_beacon.core.light_code.lamp_rows import LampRows, rows_from_frame


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
