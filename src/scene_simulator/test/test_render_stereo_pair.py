"""The command leaves what a camera driver and a calibration would leave, and the truth."""

from __future__ import annotations

import csv
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from scene_simulator.commands import render_stereo_pair
from scene_simulator.corridor_generator import CorridorDesign, corridor


def test_pictures_calibration_and_points_are_written(tmp_path: Path) -> None:
    folder = tmp_path / 'new' / 'pair'
    assert (
        render_stereo_pair.main([str(folder), '--seed', '3', '--pose', '-3.2', '0.1', '0.05', '--raw']) == 0
    )
    for side in ('left', 'right'):
        assert cv2.imread(str(folder / f'{side}.png'), cv2.IMREAD_UNCHANGED).shape == (480, 752)
        assert yaml.safe_load((folder / f'{side}.yaml').read_text())['camera_name'] == side
    with (folder / 'points.csv').open() as file:
        rows = {row['name']: (row['x'], row['y'], row['z']) for row in csv.DictReader(file)}
    expected = corridor(CorridorDesign(3)).points_map()
    assert rows.keys() == expected.keys()
    np.testing.assert_allclose(np.array(rows['cabinet/2'], float), expected['cabinet/2'], atol=1e-6)


def test_a_bad_argument_ends_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / 'file').write_text('')
    for options, complaint in (
        ([str(tmp_path / 'file' / 'pair')], 'cannot be written'),
        ([str(tmp_path / 'pair'), '--seed', '-1'], 'seed'),
        ([str(tmp_path / 'pair'), '--people', '-1'], 'people'),
    ):
        assert render_stereo_pair.main(options) == 1
        lines = capsys.readouterr().err.splitlines()
        assert len(lines) == 1
        assert complaint in lines[0]
