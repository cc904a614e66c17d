from pathlib import Path

import numpy as np
import pytest
from pdf_dots import PdfPage, read_pages
from scipy.spatial import cKDTree

from floor_localizer.commands.print_mat import main
from floor_localizer.files.dot_map_file import load_csv

MARGIN = 12.0


@pytest.fixture
def printed(run):
    """Prints a mat and returns the pages."""

    def print_mat(path: Path, *arguments: object) -> list[PdfPage]:
        code, _, err = run(main, '--out', path, *arguments)
        assert code == 0, err
        return read_pages(path.read_bytes())

    return print_mat


def test_each_dot_is_printed_where_the_map_says(tmp_path, printed):
    (page,) = printed(tmp_path / 'mat.pdf', '--seed', 3)
    dots = load_csv(tmp_path / 'mat.csv')
    np.testing.assert_allclose(page.size, (210.0, 297.0), atol=1e-6)
    assert len(page.middles) == len(dots)
    distances, nearest = cKDTree(page.middles - MARGIN).query(1000.0 * dots.points)
    assert distances.max() < 0.05
    assert len(set(nearest)) == len(dots)
    np.testing.assert_allclose(page.diameters, 2.5, atol=0.01)
    assert b'seed 3' in page.strings
    assert b'100 mm' in page.strings


def test_tiles_glued_by_their_marks_make_the_whole_mat(tmp_path, printed):
    size = ('--width', 0.3, '--height', 0.4, '--overlap', 0.015)
    pages = printed(tmp_path / 'mat.pdf', '--seed', 3, *size)
    dots = 1000.0 * load_csv(tmp_path / 'mat.csv').points
    assert len(pages) == 4
    width, height = (size - 2 * MARGIN - 15.0 for size in pages[0].size)
    covered = np.zeros(len(dots), dtype=int)
    for number, page in enumerate(pages):
        row, column = divmod(number, 2)
        assert f'row {row + 1} of 2, column {column + 1} of 2'.encode() in page.strings
        middles = page.middles - MARGIN + (column * width, row * height)
        distances, nearest = cKDTree(dots).query(middles)
        assert distances.max() < 0.05
        covered[nearest] += 1
    assert covered.min() >= 1
    # Each strip of 15 mm is on two pages.
    assert 0.08 < np.mean(covered >= 2) < 0.15


def test_a_roll_is_one_long_page(tmp_path, printed):
    options = ('--paper', 'roll', '--roll-width', 0.3, '--width', 0.25, '--height', 0.6)
    (page,) = printed(tmp_path / 'mat.pdf', *options)
    np.testing.assert_allclose(page.size, (300.0, 624.0), atol=1e-6)
    assert len(page.middles) == len(load_csv(tmp_path / 'mat.csv'))


def test_the_same_seed_prints_the_same_bytes_and_without_a_seed_mats_differ(tmp_path, printed):
    for name, seed in (('a', ['--seed', 7]), ('b', ['--seed', 7]), ('c', []), ('d', [])):
        printed(tmp_path / f'{name}.pdf', *seed)
    assert (tmp_path / 'a.pdf').read_bytes() == (tmp_path / 'b.pdf').read_bytes()
    assert len({(tmp_path / f'{name}.csv').read_bytes() for name in 'abcd'}) == 3


@pytest.mark.parametrize(('arguments', 'part'), [
    ('--seed -1', '--seed: -1 is out of range'),
    ('--diameter 0.004', '--spacing: dots of 4 mm would touch at 4 mm'),
    ('--density 90000', '--density: 90000 dots/m² do not fit'),
    ('--density 500 --view-size 0.03', 'are not unique'),
    ('--density 60 --width 0.1 --height 0.1', 'fewer than 20 dots'),
    ('--width -1', 'width is -1'),
    ('--paper roll --width 1', 'does not fit a roll of 0.914 m'),
    ('--paper roll --height 6', 'does not fit a roll of 0.914 m'),
    ('--width 20 --height 20', 'pages of A4; choose larger paper'),
    ('--out file/mat.pdf', 'choose a writable place'),
])  # fmt: skip
def test_bad_input_is_one_line_and_exit_code_1(tmp_path, refusal, monkeypatch, arguments, part):
    monkeypatch.chdir(tmp_path)
    Path('file').write_text('')
    assert part in refusal(main, *arguments.split())
