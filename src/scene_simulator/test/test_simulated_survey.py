"""The dot map of a survey: its error, its file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from scene_simulator.dot_floor import FloorDesign, generate_dot_floor
from scene_simulator.errors import SceneError
from scene_simulator.simulated_survey import survey_floor, write_dot_map

FLOOR = generate_dot_floor(FloorDesign(size=(0.8, 0.8), count=3000), 2)


def test_the_survey_is_off_by_its_error() -> None:
    errors = survey_floor(FLOOR, 0.00005, 1) - np.column_stack([FLOOR.points, FLOOR.diameters])
    np.testing.assert_allclose(errors.std(axis=0), 0.00005, rtol=0.06)
    assert np.abs(errors.mean(axis=0)).max() < 0.000005


def test_a_map_is_read_back_to_the_micrometre(tmp_path: Path) -> None:
    dots = survey_floor(FLOOR, 0.0, 1)
    write_dot_map(dots, tmp_path / 'deep' / 'floor.csv')
    path = tmp_path / 'deep' / 'floor.csv'
    assert path.read_text().startswith('x,y,diameter\n')
    np.testing.assert_allclose(np.loadtxt(path, delimiter=',', skiprows=1), dots, atol=0.51e-6)
    assert list(path.parent.iterdir()) == [path]


def test_a_place_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / 'file').write_text('')
    with pytest.raises(SceneError, match='cannot be written'):
        write_dot_map(np.zeros((1, 3)), tmp_path / 'file' / 'floor.csv')


def test_an_impossible_error_is_refused() -> None:
    with pytest.raises(SceneError, match='survey error'):
        survey_floor(FLOOR, -1.0, 1)
