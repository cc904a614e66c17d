"""Common style of the report's figures: colours, labels, file format."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import matplotlib as mpl

mpl.use('Agg')

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from scene_simulator.mission.layout import ZONES
from shirube_bringup.report.trace_errors import Array, zone_spans
from shirube_core.files import atomic_write

COLOURS = {
    'floor_localizer': '#15803d',
    'stereo_landmark': '#7c3aed',
    'vlc_beacon': '#d97706',
    'pose_arbiter': '#c2410c',
    'odometry': '#64748b',
}
LABELS = {'pose_arbiter': 'fused (pose_arbiter)', 'odometry': 'odometry alone'}
TRUTH = '#1d4ed8'
ZONE_COLOURS = {'carpet': '#a16207', 'dark': '#1e293b', 'covered': '#0e7490'}
ZONE_LABELS = {'carpet': 'carpet: no dots', 'dark': 'lamps off', 'covered': 'landmarks covered'}


@contextmanager
def picture(path: Path, width: float, height: float) -> Iterator[Figure]:
    """Provide a figure of a size [inch]; write it to a PNG file at the end."""
    figure = plt.figure(figsize=(width, height), layout='constrained')
    try:
        yield figure
        with atomic_write(path) as file:
            figure.savefig(file, format='png', dpi=100, bbox_inches='tight')
    finally:
        plt.close(figure)


def shade_zones(axes: Axes, truth: Array) -> None:
    """Shade the times at which the robot was in a zone."""
    for name, spans in zone_spans(truth).items():
        for number, (start, end) in enumerate(spans):
            label = ZONE_LABELS[name] if number == 0 else None
            axes.axvspan(start, end, color=ZONE_COLOURS[name], alpha=0.15, linewidth=0, label=label)


def mark_goals(axes: Axes, ends: list[float]) -> None:
    """Mark the end time of each goal [s]."""
    for number, end in enumerate(ends, start=1):
        axes.axvline(end, color='k', linewidth=0.8, linestyle=':')
        axes.annotate(f'goal {number} ', (end, 1.0), xycoords=('data', 'axes fraction'),
                      ha='right', va='top', fontsize='small')  # fmt: skip


def draw_zones(axes: Axes) -> None:
    """Draw the zones on a plan of the room."""
    for name, zone in ZONES.items():
        size = zone.high[0] - zone.low[0], zone.high[1] - zone.low[1]
        axes.add_patch(
            plt.Rectangle(zone.low, *size, color=ZONE_COLOURS[name], alpha=0.15, label=ZONE_LABELS[name])
        )
