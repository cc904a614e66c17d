"""A picture of a drive under lamps: the track with its commands, and the errors over time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib as mpl

mpl.use('Agg')

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from shirube_core.files import atomic_write

if TYPE_CHECKING:
    from lamp_drive import LampDrive

TRUTH, POSES, LAMP = '#1d4ed8', '#c2410c', '#f5b301'


def draw_lamp_drive(path: Path, drive: LampDrive) -> None:
    """Write the picture as a PNG file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure = plt.figure(figsize=(13.0, 6.0), layout='constrained')
    grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.3))
    _draw_track(figure.add_subplot(grid[:, 0]), drive)
    _draw_errors(figure.add_subplot(grid[0, 1]), drive)
    _draw_lamps(figure.add_subplot(grid[1, 1]), drive)
    with atomic_write(path) as file:
        figure.savefig(file, format='png', dpi=110)
    plt.close(figure)


def _draw_track(axes: Axes, drive: LampDrive) -> None:
    axes.plot(
        drive.truth[:, 0], drive.truth[:, 1], color=TRUTH, linewidth=4.0, alpha=0.35, label='true drive'
    )
    # Every sixth pose, ten a second: where the robot is slow they are dense, as in the paper's figure 4.
    axes.plot(drive.poses[::6, 0], drive.poses[::6, 1], '.', color=POSES, markersize=4.0, label='poses')
    axes.plot(*drive.truth[0, :2], 'o', color=TRUTH, markersize=8.0, label='start')
    for beacon in drive.beacons:
        axes.add_patch(Circle(beacon.xyz[:2], 0.06, color=LAMP, zorder=3))
        axes.annotate(f'lamp {beacon.id}', beacon.xyz[:2], (0, -22), textcoords='offset points', ha='center')
    places: dict[tuple[int, ...], list[str]] = {}
    for each in drive.accepted_commands:
        place = tuple(np.round(drive.truth[each.image, :2] * 5.0).astype(int).tolist())
        places.setdefault(place, []).append(each.text.rsplit(' of ')[0])
        axes.plot(*drive.truth[each.image, :2], 'k*', markersize=9.0)
    for place, text in places.items():
        axes.annotate(
            '\n'.join(text),
            (place[0] / 5.0, place[1] / 5.0),
            (-92, -34),
            textcoords='offset points',
            fontsize='small',
        )
    axes.set(
        aspect='equal', xlabel='x [m]', ylabel='y [m]', title='Commands of the lamps are obeyed at the stars'
    )
    axes.margins(0.12)
    axes.legend(loc='center', fontsize='small')


def _draw_errors(axes: Axes, drive: LampDrive) -> None:
    axes.plot(drive.seconds, 1e3 * drive.errors, '.', color=POSES, markersize=3.0, label='error')
    axes.plot(drive.seconds, 1e3 * drive.sigmas, color='k', linewidth=0.8, label='stated sigma')
    axes.set(ylabel='position [mm]', title='Error against the true drive', ylim=(0.0, None))
    axes.legend(fontsize='small')


def _draw_lamps(axes: Axes, drive: LampDrive) -> None:
    axes.step(drive.seconds, drive.identified, color='k', linewidth=0.8)
    axes.set(xlabel='time [s]', ylabel='lamps', title='Lamps with a name in view', ylim=(-0.2, 4.4))
