from pathlib import Path

import numpy as np
import pytest
from dot_maps import random_map

from floor_localizer.core.dots import DotMap
from floor_localizer.core.errors import DotMapError
from floor_localizer.files.dot_map_file import load_csv, save_csv
from floor_localizer.localization.localizer_from_map_file import DEMO_MAP

LINES = [f'{0.01 * (i % 7):.3f},{0.01 * (i // 7):.3f},0.0025' for i in range(30)]


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / 'floor.csv'
    path.write_text(text)
    return path


def csv_of(lines: list[str], header: str = 'x,y,diameter') -> str:
    return '\n'.join([header, *lines, ''])


def refusal(path: Path) -> str:
    with pytest.raises(DotMapError) as caught:
        load_csv(path)
    message = str(caught.value)
    assert str(path) in message
    assert '\n' not in message
    return message


def test_load_gives_what_was_saved(tmp_path):
    dot_map = random_map(1)
    dot_map.diameters[::3] = np.nan
    save_csv(tmp_path / 'floor.csv', dot_map)
    loaded = load_csv(tmp_path / 'floor.csv')
    np.testing.assert_array_equal(loaded.points, dot_map.points)
    np.testing.assert_array_equal(loaded.diameters, dot_map.diameters)


def test_blanks_blank_lines_carriage_returns_and_a_byte_order_mark_do_not_matter(tmp_path):
    plain = load_csv(written(tmp_path, csv_of(LINES)))
    lines = [line.replace(',', ' , ') for line in LINES]
    path = tmp_path / 'floor.csv'
    path.write_bytes(('\ufeff' + '\r\n'.join(['X, Y, Diameter', '', *lines, '', ''])).encode())
    np.testing.assert_array_equal(load_csv(path).points, plain.points)


def test_the_demo_floor_is_the_papers_floor():
    dot_map = load_csv(DEMO_MAP)
    assert len(dot_map) == 91582
    np.testing.assert_allclose(np.ptp(dot_map.points, axis=0), (1.8, 9.45), atol=0.01)


@pytest.mark.parametrize(('line', 'part'), [
    ('0.1,0.2', '2 fields'), ('0.1,0.2,0.003,4', '4 fields'), ('0.1,wide,0.003', 'y is "wide"'),
    (',0.2,0.003', 'x is ""'), ('nan,0.2,0.003', 'x is nan'), ('0.1,inf,0.003', 'y is not finite'),
    ('0.1,0.2,NaN', 'diameter is NaN'), ('0.1,0.2,inf', 'diameter is inf'),
    ('0.1,0.2,-0.003', 'diameter is -0.003, it must be positive; leave it empty'),
    (LINES[2], 'same dot as line 4'),
])  # fmt: skip
def test_a_bad_line_is_named_with_its_field(tmp_path, line, part):
    message = refusal(written(tmp_path, csv_of([*LINES[:5], line, *LINES[5:]])))
    assert 'line 7' in message
    assert part in message


@pytest.mark.parametrize(('content', 'part'), [
    (None, 'No such file'), (b'\x89PNG\xff\xfe', 'is not a text file'), (b'', 'is empty'), (b'\n\n', 'is empty'),
    (csv_of(LINES, 'x,y').encode(), 'it must be "x,y,diameter"'),
    ('\n'.join(LINES).encode(), 'it must be "x,y,diameter"'),
    (csv_of([]).encode(), '0 dots'), (csv_of(LINES[:19]).encode(), '19 dots'),
])  # fmt: skip
def test_what_is_no_map_is_refused(tmp_path, content, part):
    path = tmp_path / 'floor.csv'
    if content is not None:
        path.write_bytes(content)
    assert part in refusal(path)


@pytest.mark.parametrize(('factor', 'unit'), [(1000.0, 'millimetres'), (100.0, 'centimetres')])
@pytest.mark.parametrize('diameter', [0.0025, np.nan])
def test_other_units_are_recognised(tmp_path, factor, unit, diameter):
    points = factor * random_map(2).points
    save_csv(tmp_path / 'floor.csv', DotMap(points, np.full(len(points), factor * diameter)))
    message = refusal(tmp_path / 'floor.csv')
    assert f'looks like {unit}' in message
    assert f'divide them by {factor:.0f}' in message


def test_a_map_is_whole_or_not_there(tmp_path):
    (tmp_path / 'folder').write_text('in the way')
    with pytest.raises(DotMapError, match='choose a writable place'):
        save_csv(tmp_path / 'folder' / 'floor.csv', random_map(3))
    assert [path.name for path in tmp_path.iterdir()] == ['folder']
