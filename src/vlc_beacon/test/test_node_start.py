"""Startup errors of the node."""

from __future__ import annotations

from pathlib import Path

import pytest
from node_testing import run_in_process

from vlc_beacon.node import main

BEACONS = 'beacons: [{id: 1, xyz: [0.0, 0.0, 2.5], radius: 0.03}]'


@pytest.mark.parametrize(
    ('content', 'parameters', 'words'),
    [
        (None, (), 'beacons_file is not set'),
        ('beacons: []', (), 'holds no lamps'),
        (BEACONS, ('method:=guess',), 'method is'),
        (BEACONS, ('shuter:=rolling',), 'did you mean shutter?'),
        (BEACONS, ('camera_rpy:=[3.14, 0.0, 0.0]',), 'does not look up'),
        (BEACONS, ('key_file:=/no/such/key',), 'counter_file is not set'),
        (BEACONS, ('key_file:=/no/such/key', 'counter_file:=/tmp/counters'), '/no/such/key cannot be read'),
    ],
)
def test_a_bad_start_is_one_line_and_exit_code_1(
    tmp_path: Path,
    content: str | None,
    parameters: tuple[str, ...],
    words: str,
    capfd: pytest.CaptureFixture[str],
) -> None:
    path = tmp_path / 'beacons.yaml'
    given = list(parameters)
    if content is not None:
        path.write_text(content)
        given.append(f'beacons_file:={path}')
    arguments = ['--ros-args', *(word for parameter in given for word in ('-p', parameter))] if given else []
    assert run_in_process(main, *arguments) == 1
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith('vlc_beacon: ')
    assert words in line
