"""A mat as a PDF at true scale: one page a sheet, vectors in exact millimetres.

Marks and text are in the margins only, because the camera would detect them as dots.
"""

from typing import Any, BinaryIO

import numpy as np
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrow, Rectangle
from matplotlib.path import Path as Outline
from matplotlib.text import Text
from matplotlib.transforms import Affine2D, Transform

from floor_localizer.core.mat.page_layout import Layout, Mat, Page

_INCH = 0.0254
_HAIRLINE, _TEXT_SIZE = 0.3, 6.0  # [pt]
_MARK = 0.004  # length of a trim mark [m]
_GAP = 0.0015  # distance between the mat and the marks in the margin [m]
_SCALE_BAR = 0.1


def draw_mat(file: BinaryIO, mat: Mat, layout: Layout) -> None:
    """Write the PDF; the output is deterministic."""
    with PdfPages(file, metadata={'CreationDate': None, 'Title': _title(mat)}) as pdf:
        for page in layout.pages:
            pdf.savefig(_draw_page(mat, layout, page))


class _Canvas:
    """A page whose artists have coordinates on the mat, in metres."""

    def __init__(self, layout: Layout, page: Page) -> None:
        self.figure = Figure(figsize=(layout.page_size[0] / _INCH, layout.page_size[1] / _INCH))
        margin = layout.settings.margin
        self.mat: Transform = (
            Affine2D().translate(margin - page.x0, margin - page.y0).scale(1.0 / _INCH) + self.figure.dpi_scale_trans
        )

    def lines(self, segments: list[list[tuple[float, float]]], width: float = _HAIRLINE) -> None:
        self.figure.add_artist(LineCollection(segments, linewidths=width, colors='black', transform=self.mat))

    def text(self, x: float, y: float, text: str, **form: Any) -> None:
        self.figure.add_artist(
            Text(x, y, text, fontsize=_TEXT_SIZE, color='black', transform=self.mat, figure=self.figure, **form)
        )

    def arrow(self, x: float, y: float, dx: float, dy: float) -> None:
        self.figure.add_artist(
            FancyArrow(
                x, y, dx, dy, width=0.0004, head_width=0.002, head_length=0.003, length_includes_head=True,
                facecolor='black', edgecolor='none', transform=self.mat,
            )
        )  # fmt: skip


def _draw_page(mat: Mat, layout: Layout, page: Page) -> Figure:
    canvas = _Canvas(layout, page)
    _draw_dots(canvas, mat, page)
    _draw_trim_marks(canvas, page)
    _draw_glue_marks(canvas, layout, page)
    _draw_scale_bar(canvas, page)
    if page.row == 0 and page.column == 0:
        _draw_origin(canvas)
    lines = [_title(mat)]
    if len(layout.pages) > 1:
        lines[0] += f' | sheet row {page.row + 1} of {layout.rows}, column {page.column + 1} of {layout.columns}'
    top = page.y0 + page.height + _GAP
    canvas.text(page.x0 + _MARK, top, '\n'.join(lines), va='bottom', ha='left')
    return canvas.figure


def _title(mat: Mat) -> str:
    settings = mat.settings
    return (
        f'shirube mat | seed {mat.seed} | {1e3 * settings.width:g} x {1e3 * settings.height:g} mm | '
        f'{len(mat.points)} dots of {1e3 * settings.diameter:g} mm, {settings.density:g}/m², '
        f'{1e3 * settings.spacing:g} mm apart or more | print at 100 %'
    )


def _draw_dots(canvas: _Canvas, mat: Mat, page: Page) -> None:
    """Draw the dots of the page, clipped at its border."""
    radius = 0.5 * mat.settings.diameter
    off = mat.points - (page.x0, page.y0)
    shown = mat.points[((off > -radius) & (off < np.array([page.width, page.height]) + radius)).all(axis=1)]
    dots = PathCollection(
        [Outline.unit_circle().transformed(Affine2D().scale(radius / _INCH))],
        offsets=shown,
        offset_transform=canvas.mat,
        transform=canvas.figure.dpi_scale_trans,
        facecolors='black',
        edgecolors='none',
        linewidths=0.0,
    )
    canvas.figure.add_artist(dots)
    dots.set_clip_path(Rectangle((page.x0, page.y0), page.width, page.height, transform=canvas.mat))


def _draw_trim_marks(canvas: _Canvas, page: Page) -> None:
    """Draw two ticks outside each corner of the page's part of the mat."""
    left, right = page.x0, page.x0 + page.width
    lower, upper = page.y0, page.y0 + page.height
    segments = []
    for x, out_x in ((left, -1.0), (right, 1.0)):
        for y, out_y in ((lower, -1.0), (upper, 1.0)):
            segments.append([(x + out_x * _GAP, y), (x + out_x * (_GAP + _MARK), y)])
            segments.append([(x, y + out_y * _GAP), (x, y + out_y * (_GAP + _MARK))])
    canvas.lines(segments)


def _draw_glue_marks(canvas: _Canvas, layout: Layout, page: Page) -> None:
    """Mark in the margins the positions of the neighbours' trimmed borders."""
    overlap = layout.settings.overlap
    left, right = page.x0, page.x0 + page.width
    lower, upper = page.y0, page.y0 + page.height
    if page.column + 1 < layout.columns:
        x = right - overlap
        canvas.lines([[(x, lower - _GAP), (x, lower - _GAP - _MARK)], [(x, upper + _GAP), (x, upper + _GAP + _MARK)]])
        label = f'column {page.column + 2} is glued on from here'
        canvas.text(x - 0.001, lower - _GAP, label, va='top', ha='right')
    if page.row + 1 < layout.rows:
        y = upper - overlap
        canvas.lines([[(left - _GAP, y), (left - _GAP - _MARK, y)], [(right + _GAP, y), (right + _GAP + _MARK, y)]])
        label = f'row {page.row + 2} is glued on from here'
        canvas.text(left - _GAP, y - 0.001, label, va='top', ha='right', rotation=90.0)


def _draw_scale_bar(canvas: _Canvas, page: Page) -> None:
    """Draw a scale bar to check the printer, 100 mm or as long as fits."""
    length = min(_SCALE_BAR, max(0.01 * int(100.0 * (page.width - 0.06)), 0.02))
    start, y = page.x0 + 0.015, page.y0 - 2.0 * _GAP - _MARK
    ticks = [
        [(start + 0.01 * k, y), (start + 0.01 * k, y + (0.002 if k % 5 == 0 else 0.001))]
        for k in range(round(length / 0.01) + 1)
    ]
    canvas.lines([[(start, y), (start + length, y)], *ticks], width=0.5)
    canvas.text(start + length + 0.002, y, f'{1e3 * length:g} mm: measure it', va='bottom', ha='left')


def _draw_origin(canvas: _Canvas) -> None:
    """Draw the map's origin and axes next to the lower left corner."""
    canvas.arrow(0.0, -_GAP, 0.011, 0.0)
    canvas.arrow(-_GAP, 0.0, 0.0, 0.011)
    canvas.text(0.012, -_GAP, 'x', va='center', ha='left')
    canvas.text(-_GAP, 0.012, 'y', va='bottom', ha='center')
    canvas.text(-_GAP, -_GAP, '0', va='top', ha='right')
