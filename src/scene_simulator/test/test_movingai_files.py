"""Tests of MovingAI files."""

from pathlib import Path

import pytest

from scene_simulator.errors import SceneError
from scene_simulator.room.movingai_files import Scenario, load_movingai_map, load_movingai_scenarios

MAP = 'type octile\nheight 2\nwidth 3\nmap\n.@.\nTGS\n'


def test_a_map_is_read_from_its_first_line_down(tmp_path: Path) -> None:
    path = tmp_path / 'small.map'
    path.write_text(MAP)
    assert load_movingai_map(path).tolist() == [[False, True, False], [True, False, False]]


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('', 'that begins with type'),
        (MAP.replace('height 2', 'height x'), 'whole numbers'),
        (MAP.replace('height 2', 'height 3'), '3 lines of 3 cells'),
        (MAP.replace('.@.', '.@'), '2 lines of 3 cells'),
        (MAP.replace('.@.', '.?.'), "'\\?'"),
        ('\xff', 'not a text file'),
    ],
)
def test_what_is_no_map_is_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / 'bad.map'
    path.write_text(text, encoding='latin-1')
    with pytest.raises(SceneError, match=message):
        load_movingai_map(path)


def test_scenarios_hold_x_before_y(tmp_path: Path) -> None:
    path = tmp_path / 'small.scen'
    path.write_text('version 1\n0\tsmall.map\t3\t2\t2\t0\t1\t1\t1.5\n\n')
    assert load_movingai_scenarios(path) == [Scenario((0, 2), (1, 1), 1.5)]


@pytest.mark.parametrize('line', ['0 small.map 3 2 2 0 1 1', '0 small.map 3 2 x 0 1 1 1.5'])
def test_what_is_no_scenario_is_refused_with_its_line(tmp_path: Path, line: str) -> None:
    path = tmp_path / 'bad.scen'
    path.write_text(f'version 1\n{line}\n')
    with pytest.raises(SceneError, match='line 2'):
        load_movingai_scenarios(path)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match='cannot be read'):
        load_movingai_map(tmp_path / 'none.map')
