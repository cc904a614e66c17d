"""Layout of a mat on pages of paper.

A page shows a rectangle of the mat, and neighbouring pages share a strip of ``overlap``: the page to the right (or
above) is trimmed along its left (lower) border and glued onto that strip.
"""

import math
from dataclasses import dataclass

from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.mat.random_mat import MatSettings
from shirube_core.settings import setting

PAPERS = {'A4': (0.210, 0.297), 'A3': (0.297, 0.420), 'A2': (0.420, 0.594), 'A1': (0.594, 0.841), 'A0': (0.841, 1.189)}
"""Width and height of pages in portrait format (ISO 216) [m]."""

ROLL = 'roll'
# The largest PDF page has 14400 points.
_MAX_PAGE_LENGTH = 14400 / 72 * 0.0254
_MAX_PAGES = 1000


@dataclass(frozen=True)
class PageSettings:
    """The paper."""

    margin: float = setting(0.012, 'margin of each page, which contains the marks', 'm', (0.01, 0.05))
    overlap: float = setting(0.01, 'overlap of two pages that are glued together', 'm', (0.0, 0.05))
    roll_width: float = setting(0.914, 'width of the roll', 'm', (0.1, 5.0))


@dataclass(frozen=True)
class Page:
    """One page and the rectangle of the mat it shows.

    Attributes:
        row: row, counted from the bottom.
        column: column, counted from the left.
        x0: left border of the rectangle on the mat [m].
        y0: lower border of the rectangle on the mat [m].
        width: width of the rectangle [m].
        height: height of the rectangle [m].
    """

    row: int
    column: int
    x0: float
    y0: float
    width: float
    height: float


@dataclass(frozen=True)
class Layout:
    """All pages of a mat.

    Attributes:
        paper: name of the paper format.
        page_size: width and height of a page [m].
        settings: margin and overlap.
        rows: number of rows.
        columns: number of columns.
        pages: pages, row by row from the bottom, left to right.
    """

    paper: str
    page_size: tuple[float, float]
    settings: PageSettings
    rows: int
    columns: int
    pages: tuple[Page, ...]


def mat_size_of_page(paper: str, settings: PageSettings) -> tuple[float, float]:
    """Return width and height of the mat that fills one page [m]; on a roll it is a square."""
    width, height = PAPERS.get(paper, (settings.roll_width, settings.roll_width))
    return round(width - 2.0 * settings.margin, 6), round(height - 2.0 * settings.margin, 6)


def divide_into_pages(mat: MatSettings, paper: str, settings: PageSettings) -> Layout:
    """Divide a mat into pages, in portrait or landscape, whichever needs fewer; paper is one of `PAPERS`, or `ROLL`.

    Raises:
        FloorLocalizerError: the mat is too wide or long for the roll, or needs too many pages.
    """
    if paper == ROLL:
        page_size = (settings.roll_width, mat.height + 2.0 * settings.margin)
        if mat.width > settings.roll_width - 2.0 * settings.margin + 1e-9 or page_size[1] > _MAX_PAGE_LENGTH:
            raise FloorLocalizerError(
                f'--paper: a mat of {mat.width:g} x {mat.height:g} m does not fit a roll of '
                f'{settings.roll_width:g} m (a PDF page ends at {_MAX_PAGE_LENGTH:.2f} m); print several mats or pages'
            )
        return _divide(mat, paper, page_size, settings)
    upright = PAPERS[paper]
    layouts = [_divide(mat, paper, page_size, settings) for page_size in (upright, (upright[1], upright[0]))]
    best = min(layouts, key=lambda layout: layout.rows * layout.columns)
    if best.rows * best.columns > _MAX_PAGES:
        raise FloorLocalizerError(
            f'--paper: the mat needs {best.rows * best.columns} pages of {paper}; choose larger paper or a roll'
        )
    return best


def _divide(mat: MatSettings, paper: str, page_size: tuple[float, float], settings: PageSettings) -> Layout:
    shown_size = (page_size[0] - 2.0 * settings.margin, page_size[1] - 2.0 * settings.margin)
    columns = _starts(mat.width, shown_size[0], settings.overlap)
    rows = _starts(mat.height, shown_size[1], settings.overlap)
    pages = tuple(
        Page(row, column, x0, y0, min(shown_size[0], mat.width - x0), min(shown_size[1], mat.height - y0))
        for row, y0 in enumerate(rows)
        for column, x0 in enumerate(columns)
    )
    return Layout(paper, page_size, settings, len(rows), len(columns), pages)


def _starts(length: float, shown_size: float, overlap: float) -> list[float]:
    """Return the start positions of the pages along one side [m]."""
    if shown_size >= length - 1e-9:
        return [0.0]
    number = math.ceil((length - overlap) / (shown_size - overlap) - 1e-9)
    return [index * (shown_size - overlap) for index in range(number)]
