"""A plot of a dot map: its density, and the places that are not unique."""

from __future__ import annotations

from collections.abc import Sequence
from typing import BinaryIO

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from floor_localizer.core.uniqueness import Place, PlaceKind

_LONG_SIDE, _MIN_SHORT_SIDE = 10.0, 3.0  # size of the plot [inch]
_MARGIN = np.array([1.5, 1.0])  # margin for scales and legend [inch]
_DOTS_PER_CELL = 60.0
_MARKS = {
    PlaceKind.TOO_FEW_DOTS: ('tab:orange', 'v'),
    PlaceKind.AMBIGUOUS: ('tab:red', 'o'),
    PlaceKind.MIRROR_AMBIGUOUS: ('tab:purple', 'D'),
}


def draw_map(file: BinaryIO, points: NDArray[np.float64], places: Sequence[Place], title: str) -> None:
    """Write a PNG.

    Args:
        file: open for writing.
        points: shape (N, 2), the dots [m].
        places: inspected places.
        title: title of the plot.
    """
    size = np.maximum(np.ptp(points, axis=0), 1e-3)
    proportions = size / size.max()
    figure = Figure(
        figsize=np.maximum(_LONG_SIDE * proportions, _MIN_SHORT_SIDE) + _MARGIN, layout='constrained'
    )
    axes = figure.add_subplot(aspect='equal', xlabel='x [m]', ylabel='y [m]', title=title)
    _draw_density(figure, axes, points, size)
    for kind, (colour, mark) in _MARKS.items():
        xy = np.array([(place.x, place.y) for place in places if place.kind is kind]).reshape(-1, 2)
        if len(xy):
            axes.plot(*xy.T, mark, color=colour, fillstyle='none', label=f'{kind.value} ({len(xy)})')
    if axes.get_legend_handles_labels()[0]:
        figure.legend(loc='outside lower center')
    figure.savefig(file, format='png', dpi=100)


def _draw_density(figure: Figure, axes: Axes, points: NDArray[np.float64], size: NDArray[np.float64]) -> None:
    cell = float(np.sqrt(np.prod(size) * _DOTS_PER_CELL / len(points)))
    counts = np.maximum((size / cell).astype(int), 1)
    dots, x_edges, y_edges = np.histogram2d(points[:, 0], points[:, 1], bins=[int(count) for count in counts])
    density = dots.T / np.prod(size / counts)
    shades = axes.pcolormesh(x_edges, y_edges, density, cmap='Greys', vmin=0.0, vmax=1.5 * density.max())
    figure.colorbar(shades, ax=axes, label='dots/m²', shrink=0.6)
