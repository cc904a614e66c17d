"""Tests of MovingAI files."""

from pathlib import Path

import pytest
from movingai_files import load_movingai_map

from scene_simulator.errors import SceneError

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
    with pytest.raises(SceneError, match='cannot be read'):
        load_movingai_map(path)
    path.write_text(text, encoding='latin-1')
    with pytest.raises(SceneError, match=message):
        load_movingai_map(path)
