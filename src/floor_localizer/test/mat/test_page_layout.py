import numpy as np
import pytest

from floor_localizer.core.mat.page_layout import PAPERS, MatSettings, PageSettings, divide_into_pages, mat_size_of_page


@pytest.mark.parametrize('paper', PAPERS)
def test_one_page_shows_the_mat_that_fills_it(paper):
    width, height = mat_size_of_page(paper, PageSettings())
    layout = divide_into_pages(MatSettings(width=width, height=height), paper, PageSettings())
    assert len(layout.pages) == 1
    assert layout.page_size == PAPERS[paper]


@pytest.mark.parametrize('size', [(0.5, 0.3), (1.2, 0.9), (0.19, 0.8)])
def test_pages_cover_the_mat_and_overlap(size):
    settings = PageSettings()
    layout = divide_into_pages(MatSettings(width=size[0], height=size[1]), 'A4', settings)
    for axis, number in (('x0', layout.columns), ('y0', layout.rows)):
        side = 'width' if axis == 'x0' else 'height'
        spans = sorted({(getattr(s, axis), getattr(s, axis) + getattr(s, side)) for s in layout.pages})
        assert len(spans) == number
        assert spans[0][0] == 0.0
        np.testing.assert_allclose(spans[-1][1], size[axis == 'y0'])
        for before, after in zip(spans, spans[1:]):
            np.testing.assert_allclose(before[1] - after[0], settings.overlap)


def test_a_wide_mat_turns_the_paper():
    layout = divide_into_pages(MatSettings(width=0.27, height=0.18), 'A4', PageSettings())
    assert len(layout.pages) == 1
    assert layout.page_size == (0.297, 0.21)
