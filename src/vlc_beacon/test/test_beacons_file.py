from pathlib import Path

import pytest

from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.files.beacons_file import BeaconsFileError, load_beacons, save_beacons

GOOD = '{id: 7, xyz: [1, 2.5, 3], radius: 0.0325}'


def write(tmp_path, text):
    path = tmp_path / 'beacons.yaml'
    path.write_text(text)
    return path


def test_lamps_are_read_in_their_order(tmp_path):
    text = """
beacons:
- {id: 7, xyz: [1, 2.5, 3], radius: 0.0325}
- id: 3
  xyz: [-1.0, 0.0, 2.46]
  radius: 0.05
  frequency: 2500
"""
    assert load_beacons(write(tmp_path, text)) == [
        Beacon(7, (1.0, 2.5, 3.0), 0.0325, None),
        Beacon(3, (-1.0, 0.0, 2.46), 0.05, 2500.0),
    ]


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('beacons: [', 'is no YAML'),
        ('beacons: 2024-13-45', 'is no YAML'),
        ('beacons: ' + '[' * 1000, 'is no YAML'),
        (f'beacons: [{{id: 1, xyz: [1, 2, {10**400}], radius: 0.03}}]', 'xyz is a huge number m'),
        ('beacons: [{id: 1, xyz: [1, 2, 3], radius: 3e-2}]', 'write it like 0.01'),
        ('- 1', 'holds no fields'),
        ('beacons: []', 'holds no lamps'),
        ('becons: []', 'field becons does not exist, did you mean beacons'),
        ('beacons: [7]', 'beacon number 1 is 7'),
        ('beacons: [{xyz: [1, 2, 3], radius: 0.03}]', 'beacon number 1: id is missing'),
        ('beacons: [{id: 1, radius: 0.03}]', 'xyz is missing'),
        ('beacons: [{id: 1, xyz: [1, 2, 3]}]', 'radius is missing'),
        ('beacons: [{id: one, xyz: [1, 2, 3], radius: 0.03}]', "id is 'one'"),
        ('beacons: [{id: true, xyz: [1, 2, 3], radius: 0.03}]', 'id is True'),
        ('beacons: [{id: -1, xyz: [1, 2, 3], radius: 0.03}]', 'id is -1'),
        ('beacons: [{id: 1, xyz: [1, 2], radius: 0.03}]', 'beacon 1: xyz is'),
        ('beacons: [{id: 1, xyz: [1, .nan, 3], radius: 0.03}]', 'xyz is nan, not a number'),
        ('beacons: [{id: 1, xyz: [1, .inf, 3], radius: 0.03}]', 'xyz is inf'),
        ('beacons: [{id: 1, xyz: [1, "2", 3], radius: 0.03}]', "xyz is '2'"),
        ('beacons: [{id: 1, xyz: [1, 2, 30000000], radius: 0.03}]', 'xyz is 3e\\+07 m'),
        ('beacons: [{id: 1, xyz: [1, 2, 3], radius: 32.5}]', 'radius is 32.5 m, .* is it in m'),
        ('beacons: [{id: 1, xyz: [1, 2, 3], radius: 0}]', 'radius is 0 m'),
        ('beacons: [{id: 1, xyz: [1, 2, 3], radius: 0.03, frequency: 2}]', 'frequency is 2 Hz'),
        ('beacons: [{id: 1, xyz: [1, 2, 3], raduis: 0.03}]', 'did you mean radius'),
        ('beacons: [{id: 1, xyz: [1, 2, 3], radius: 0.03, colour: 3}]', 'are id, xyz, radius, frequency'),
        (f'beacons: [{GOOD}, {GOOD}]', 'id 7 is used 2 times'),
        (f'beacons: [{GOOD}, {GOOD.replace("7", "8")}]', 'beacons 7 and 8 have the same xyz'),
    ],
)
@pytest.mark.newest_set_only
def test_errors_are_one_line(tmp_path, text, words):
    with pytest.raises(BeaconsFileError, match=words) as caught:
        load_beacons(write(tmp_path, text))
    assert '\n' not in str(caught.value)
    assert 'beacons.yaml' in str(caught.value)


def test_a_missing_file_and_bytes_are_no_beacons(tmp_path):
    (tmp_path / 'beacons.yaml').write_bytes(b'\xff\xfe\x00')
    for name, words in (('nothing.yaml', 'cannot be read'), ('beacons.yaml', 'is no YAML')):
        with pytest.raises(BeaconsFileError, match=words):
            load_beacons(tmp_path / name)


def test_what_is_saved_is_loaded(tmp_path: Path) -> None:
    beacons = [Beacon(1, (0.0, 1.8, 2.5), 0.0325), Beacon(7, (-1.25, 0.0001, 2.5), 0.05, 3500.0)]
    save_beacons(tmp_path / 'new' / 'beacons.yaml', beacons)
    assert load_beacons(tmp_path / 'new' / 'beacons.yaml') == beacons
