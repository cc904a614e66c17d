"""Random mats of dots, and the layout of a mat on pages of paper.

A page shows a rectangle of the mat, and neighbouring pages share a strip of ``overlap``: the page to the right (or
above) is trimmed along its left (lower) border and glued onto that strip.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from floor_localizer.core.arrays import Floats
from floor_localizer.core.constellation.indexed_map import index_map
from floor_localizer.core.dots import DotMap
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.settings import LocalizerSettings
from floor_localizer.core.uniqueness import Place, PlaceKind, ViewSettings, inspect_places, list_places
from shirube_core.settings import setting

# Largest fraction of the area covered by discs of the minimum spacing; above it, redrawing hardly terminates.
_MAX_FILL_FRACTION = 0.4
# Resolution of map files, and of the settings that enter the seed.
_RESOLUTION = 1e6
SEED_MAX = 2**32 - 1  # a seed is an integer from 0 to this
_TRIALS = 5


@dataclass(frozen=True)
class MatSettings:
    """The dots of a mat."""

    width: float = setting(0.0, 'width of the mat along x; 0 fills one page', 'm', (0.0, 20.0))
    height: float = setting(0.0, 'height of the mat along y; 0 fills one page', 'm', (0.0, 20.0))
    density: float = setting(5000.0, 'dots per square metre', '1/m^2', (50.0, 100_000.0))
    diameter: float = setting(0.0025, 'diameter of a dot', 'm', (0.0005, 0.05))
    spacing: float = setting(0.004, 'smallest distance between the centres of two dots', 'm', (0.0005, 0.2))


@dataclass(frozen=True)
class Mat:
    """A mat whose frame has its origin in the lower left corner, x to the right and y up.

    Attributes:
        settings: settings of the mat; width and height are not 0.
        seed: seed of the random dots; the same seed and settings give the same mat.
        points: centres of the dots, rounded to micrometres, shape (n, 2) [m].
    """

    settings: MatSettings
    seed: int
    points: Floats

    @property
    def dot_map(self) -> DotMap:
        """The mat as a map."""
        return DotMap(self.points, np.full(len(self.points), self.settings.diameter))


def generate_mat(settings: MatSettings, seed: int, trial: int = 0) -> Mat:
    """Generate the random dots of a mat; width and height of the settings are above 0.

    Different seeds, settings or trials (after a mat that was not unique) give entirely different dots.

    Raises:
        FloorLocalizerError: the seed is out of range, dots would overlap, or the density is too high or too low.
    """
    _check_settings(settings, seed)
    rng = np.random.default_rng([seed, trial, *_settings_seed(settings)])
    count = round(settings.density * settings.width * settings.height)
    # No dot crosses the border of the mat.
    lower = np.full(2, 0.5 * settings.diameter)
    upper = np.array([settings.width, settings.height]) - lower
    points = rng.uniform(lower, upper, (count, 2))
    while len(pairs := cKDTree(points).query_pairs(settings.spacing + 2e-6, output_type='ndarray')):
        redrawn = np.unique(pairs.max(axis=1))
        points[redrawn] = rng.uniform(lower, upper, (len(redrawn), 2))
    return Mat(settings, seed, np.round(points, 6))


def _settings_seed(settings: MatSettings) -> list[int]:
    numbers = (settings.width, settings.height, settings.diameter, settings.spacing)
    return [*(round(_RESOLUTION * number) for number in numbers), round(1000.0 * settings.density)]


def _check_settings(settings: MatSettings, seed: int) -> None:
    if not 0 <= seed <= SEED_MAX:
        raise FloorLocalizerError(f'--seed: {seed} is out of range; give 0 to {SEED_MAX}')
    if settings.spacing <= settings.diameter:
        raise FloorLocalizerError(
            f'--spacing: dots of {1e3 * settings.diameter:g} mm would touch at {1e3 * settings.spacing:g} mm; '
            'give more than the diameter'
        )
    fill_fraction = settings.density * math.pi * (0.5 * settings.spacing) ** 2
    if fill_fraction > _MAX_FILL_FRACTION:
        most = _MAX_FILL_FRACTION / (math.pi * (0.5 * settings.spacing) ** 2)
        raise FloorLocalizerError(
            f'--density: {settings.density:g} dots/m² do not fit at a spacing of '
            f'{1e3 * settings.spacing:g} mm; give at most {most:.0f}'
        )
    if settings.density * settings.width * settings.height < 20.0:
        raise FloorLocalizerError(
            f'--density: a mat of {settings.width:g} x {settings.height:g} m has fewer than 20 dots; '
            'print a larger or denser one'
        )


def generate_unique_mat(settings: MatSettings, seed: int, view: ViewSettings) -> tuple[Mat, list[Place]]:
    """Generate a mat whose views are all unique; return it with the inspected places. The same seed gives the same mat.

    Raises:
        FloorLocalizerError: no such mat was found; the message names the option to change.
    """
    for trial in range(_TRIALS):
        mat = generate_mat(settings, seed, trial)
        floor = index_map(mat.dot_map)
        places = list(inspect_places(floor, list_places(floor.grid, view), view, LocalizerSettings()))
        bad = [place for place in places if place.kind is not PlaceKind.UNIQUE]
        if not bad:
            return mat, places
    raise FloorLocalizerError(
        f'--density: {len(bad)} of {len(places)} views of {1e3 * view.view_size:.0f} mm are not unique '
        f'({bad[0].dots} dots at ({bad[0].x:.3f}, {bad[0].y:.3f}) m: {bad[0].kind.value}); '
        'give more dots, or a larger --view-size if the camera sees more'
    )


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
