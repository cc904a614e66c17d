"""The recorded drive under lamps holds what its page says: a survey of it finds the lamps that play there."""

from pathlib import Path

import numpy as np
import pytest

from vlc_beacon.commands import survey
from vlc_beacon.files.beacons_file import load_beacons

BAG = Path(__file__).parents[1] / 'bags' / 'lamp_drive'


def test_a_survey_finds_the_lamps_of_the_bag(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / 'beacons.yaml'
    assert survey.main([str(BAG), '--lamp-radius', '0.0325', '--out', str(out)]) == 0
    found, true = load_beacons(out), load_beacons(BAG / 'beacons.yaml')
    assert [beacon.id for beacon in found] == [beacon.id for beacon in true] == [1, 2, 3, 4]
    errors = np.array([beacon.xyz for beacon in found]) - [beacon.xyz for beacon in true]
    sigmas = np.array(
        [
            [float(part.split()[0]) for part in line.split('+-')[1:]]
            for line in capsys.readouterr().out.splitlines()
            if line.startswith('beacon ')
        ]
    )
    assert np.abs(errors).max() < 0.005
    assert (np.abs(errors) < 3.0 * sigmas + 0.0001).all()
