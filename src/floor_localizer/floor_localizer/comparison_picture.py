"""A picture of what two dot maps have in common and where they differ."""

from __future__ import annotations

from typing import BinaryIO

import numpy as np
from matplotlib.figure import Figure

from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.survey.map_comparison import MapComparison

_MOST_ARROWS = 1500
_LONGEST = 1.5
"""Longer differences are drawn so many times as long as the 95th percentile."""
_ARROW = 0.04
"""Length of the arrow of the 95th percentile, as a share of the picture."""


def draw_comparison(file: BinaryIO, first: DotMap, second: DotMap, found: MapComparison) -> None:
    """Write a PNG: arrows from the first map's dots to the second's, magnified, and the dots that one map lacks."""
    figure = Figure(figsize=(10.0, 9.0), layout='constrained')
    axes = figure.add_subplot(aspect='equal', xlabel='x [m]', ylabel='y [m]')
    places = first.points[found.pairs[:, 0]]
    chosen = np.linspace(0, len(places) - 1, min(len(places), _MOST_ARROWS)).astype(int)
    lengths = np.hypot(*found.residuals.T)
    typical = max(float(np.percentile(lengths, 95.0)), 1e-7)
    size = float(np.ptp(first.points, axis=0).max())
    # An arrow of two chips that became one would lie across the whole picture.
    shown = found.residuals * np.minimum(1.0, _LONGEST * typical / np.maximum(lengths, 1e-12))[:, None]
    arrows = axes.quiver(
        *places[chosen].T, *shown[chosen].T, 1e3 * lengths[chosen], angles='xy', scale_units='xy',
        scale=typical / (_ARROW * size), cmap='viridis', width=0.0015, clim=(0.0, 1e3 * _LONGEST * typical),
    )  # fmt: skip
    figure.colorbar(arrows, ax=axes, extend='max', label='second map beside the first [mm]', shrink=0.7)
    moved = found.T_first_second.transform(second.points)
    for points, colour, mark, name in (
        (first.points[found.missing], 'tab:red', 'o', f'only in the first ({len(found.missing)})'),
        (moved[found.extra], 'tab:blue', 's', f'only in the second ({len(found.extra)})'),
    ):
        if len(points):
            axes.plot(*points.T, mark, color=colour, fillstyle='none', markersize=4, label=name)
    axes.set_title(f'arrows {_ARROW * size / typical:.0f} times as long as the difference')
    if axes.get_legend_handles_labels()[0]:
        figure.legend(loc='outside lower center', ncols=2)
    figure.savefig(file, format='png', dpi=100)
