"""A plot of the differences between two dot maps."""

from __future__ import annotations

from typing import BinaryIO

import numpy as np
from matplotlib.figure import Figure

from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.survey.map_comparison import MapComparison

_MAX_ARROWS = 1500
_MAX_LENGTH = 1.5
"""Maximum length of an arrow [lengths of the 95th percentile]."""
_ARROW_LENGTH = 0.04
"""Length of the arrow of the 95th percentile, as a fraction of the plot."""


def draw_comparison(file: BinaryIO, first: DotMap, second: DotMap, found: MapComparison) -> None:
    """Write a PNG: magnified arrows from the first map's dots to the second's, and dots that are in only one map."""
    figure = Figure(figsize=(10.0, 9.0), layout='constrained')
    axes = figure.add_subplot(aspect='equal', xlabel='x [m]', ylabel='y [m]')
    places = first.points[found.pairs[:, 0]]
    chosen = np.linspace(0, len(places) - 1, min(len(places), _MAX_ARROWS)).astype(int)
    lengths = np.hypot(*found.residuals.T)
    typical = max(float(np.percentile(lengths, 95.0)), 1e-7)
    size = float(np.ptp(first.points, axis=0).max())
    # Clipped: the arrow of two chips detected as one would cross the whole plot.
    shown = found.residuals * np.minimum(1.0, _MAX_LENGTH * typical / np.maximum(lengths, 1e-12))[:, None]
    arrows = axes.quiver(
        *places[chosen].T, *shown[chosen].T, 1e3 * lengths[chosen], angles='xy', scale_units='xy',
        scale=typical / (_ARROW_LENGTH * size), cmap='viridis', width=0.0015, clim=(0.0, 1e3 * _MAX_LENGTH * typical),
    )  # fmt: skip
    figure.colorbar(arrows, ax=axes, extend='max', label='distance between the maps [mm]', shrink=0.7)
    moved = found.T_first_second.transform(second.points)
    for points, colour, mark, name in (
        (first.points[found.missing], 'tab:red', 'o', f'only in the first ({len(found.missing)})'),
        (moved[found.extra], 'tab:blue', 's', f'only in the second ({len(found.extra)})'),
    ):
        if len(points):
            axes.plot(*points.T, mark, color=colour, fillstyle='none', markersize=4, label=name)
    axes.set_title(f'arrows magnified {_ARROW_LENGTH * size / typical:.0f} times')
    if axes.get_legend_handles_labels()[0]:
        figure.legend(loc='outside lower center', ncols=2)
    figure.savefig(file, format='png', dpi=100)
