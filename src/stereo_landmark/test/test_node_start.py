"""Error messages of the node for invalid parameters and files."""

from __future__ import annotations

from pathlib import Path

import pytest
from node_testing import run_in_process
from random_places import random_images, random_place

from stereo_landmark.files.place_file import save_place
from stereo_landmark.node import main


@pytest.mark.parametrize(
    ('parameters', 'expected'),
    [
        ((), 'places_dir is not set'),
        (('places_dir:={folder}/wrong',), 'wrong.yaml: format is not shirube/taught_place'),
        (('place_dir:={folder}',), 'did you mean places_dir?'),
        (('places_dir:={folder}/right', 'map_frame:=wall'), 'place wall has the same name as map_frame'),
        (('places_dir:={folder}', 'queue_size:=0'), 'queue_size is 0, allowed is 1 to 1000'),
    ],
)
def test_a_bad_start_is_one_line_and_exit_code_1(
    tmp_path: Path, parameters: tuple[str, ...], expected: str, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / 'wrong').mkdir()
    save_place(tmp_path / 'right', random_place(1, 'wall'), random_images(1))
    (tmp_path / 'wrong/wrong.yaml').write_text('a: 1')
    given = [parameter.format(folder=tmp_path) for parameter in parameters]
    arguments = (
        ['--ros-args', *(argument for parameter in given for argument in ('-p', parameter))] if given else []
    )
    assert run_in_process(main, *arguments) == 1
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith('stereo_landmark: ')
    assert expected in line
