"""Times of rows, written out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from scene_simulator.errors import SceneError
from scene_simulator.shutter import Shutter

ROLLING = Shutter(exposure=60e-6, row_time=9e-6)


def test_a_row_starts_its_row_times_after_the_stamp() -> None:
    cuts = ROLLING.exposure_boundaries(7.0, slice(100, 103), 3)
    starts = 7.0 + np.array([900e-6, 909e-6, 918e-6])
    np.testing.assert_allclose(cuts, starts[:, None] + np.array([0.0, 20e-6, 40e-6, 60e-6]), atol=1e-12)


def test_all_rows_of_a_global_shutter_are_exposed_together() -> None:
    cuts = Shutter(exposure=0.5e-3).exposure_boundaries(7.0, slice(0, 1024), 1)
    np.testing.assert_allclose(cuts, np.broadcast_to([7.0, 7.0005], (1024, 2)), atol=1e-12)


def test_the_middle_of_a_frame_is_between_its_first_start_and_its_last_end() -> None:
    end = ROLLING.frame_end(3.0, 1024)
    assert end == pytest.approx(3.0 + 1023 * 9e-6 + 60e-6, abs=1e-12)
    assert ROLLING.frame_middle(3.0, 1024) == pytest.approx(0.5 * (3.0 + end), abs=1e-12)
    assert ROLLING.row_middle(3.0, 0) == pytest.approx(3.0 + 30e-6, abs=1e-12)


@pytest.mark.parametrize(
    ('exposure', 'row_time'),
    [(0.0, 0.0), (-1e-3, 0.0), (1e-3, -1e-6), (float('nan'), 0.0), (1e-3, float('inf'))],
)
def test_times_that_no_shutter_has_are_refused(exposure: float, row_time: float) -> None:
    with pytest.raises(SceneError, match='exposure'):
        Shutter(exposure, row_time)
