"""A picture of a replay: the track over the dots of the floor, and the errors over time."""

import math
from pathlib import Path

import matplotlib as mpl

mpl.use('Agg')

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from shirube_bags.stamps import NANOSECONDS
from shirube_bags.trajectory import interpolate
from shirube_cli.floor_replay import FloorAccuracy
from shirube_core.files import atomic_write

ESTIMATE, TRUTH, DIRT, DOTS = '#c2410c', '#1d4ed8', '#b45309', '#9aa0a6'
# The camera's view of the floor, for the close-up [m].
VIEW = 0.09


def draw_floor_picture(path: Path, accuracy: FloorAccuracy, dots: NDArray[np.float64]) -> None:
    """Write the picture as a PNG file, with the dots of the map, shape (n, 2) [m]."""
    figure = plt.figure(figsize=(13.0, 9.0), layout='constrained')
    grid = figure.add_gridspec(3, 2, width_ratios=(1.0, 2.6), height_ratios=(1.0, 1.0, 1.3))
    _draw_track(figure.add_subplot(grid[:, 0]), accuracy, dots)
    _draw_position_errors(figure.add_subplot(grid[0, 1]), accuracy)
    _draw_heading_errors(figure.add_subplot(grid[1, 1]), accuracy)
    _draw_close_up(figure.add_subplot(grid[2, 1]), accuracy, dots)
    with atomic_write(path) as file:
        figure.savefig(file, format='png', dpi=110)
    plt.close(figure)


def _draw_track(axes: Axes, accuracy: FloorAccuracy, dots: NDArray[np.float64]) -> None:
    truth, errors = accuracy.truth.positions, accuracy.errors.estimate.positions
    axes.plot(*dots.T, ',', color=DOTS, alpha=0.5, rasterized=True)
    axes.plot(truth[:, 0], truth[:, 1], color=TRUTH, linewidth=3.0, alpha=0.4, label='true drive')
    axes.plot(errors[:, 0], errors[:, 1], '.', color=ESTIMATE, markersize=2.5, label='poses from the dots')
    hidden = interpolate(accuracy.truth, accuracy.images_ns[_is_dirty(accuracy)]).positions
    axes.plot(hidden[:, 0], hidden[:, 1], 's', color=DIRT, markersize=5.0, alpha=0.35, label='floor hidden by dirt')
    missing = interpolate(accuracy.truth, accuracy.report.coverage.missing_ns).positions
    if len(missing):
        axes.plot(missing[:, 0], missing[:, 1], 'kx', markersize=6.0, label='no pose')
    axes.plot(truth[0, 0], truth[0, 1], 'o', color=TRUTH, markersize=8.0, label='start')
    axes.set(aspect='equal', xlabel='x [m]', ylabel='y [m]', title=f'The drive over {len(dots)} dots')
    axes.legend(loc='upper center', bbox_to_anchor=(0.5, -0.06), fontsize='small')


def _draw_position_errors(axes: Axes, accuracy: FloorAccuracy) -> None:
    axes.plot(_seconds(accuracy, accuracy.errors.estimate.stamps_ns), 1e3 * accuracy.errors.position, '.',
              color=ESTIMATE, markersize=3.0)  # fmt: skip
    figures = accuracy.report.position
    axes.axhline(1e3 * figures.median, color='k', linewidth=0.8, label=f'median {1e3 * figures.median:.3f} mm')
    axes.axhline(1e3 * figures.p95, color='k', linewidth=0.8, ls='--', label=f'95 % {1e3 * figures.p95:.3f} mm')
    axes.set(ylabel='position error [mm]', title='Errors against the true drive', ylim=(0.0, None))
    _mark_dirt(axes, accuracy)


def _draw_heading_errors(axes: Axes, accuracy: FloorAccuracy) -> None:
    degrees = np.degrees(accuracy.errors.heading)
    axes.plot(_seconds(accuracy, accuracy.errors.estimate.stamps_ns), degrees, '.', color=ESTIMATE, markersize=3.0)
    rms = math.degrees(accuracy.report.heading.rms)
    axes.axhspan(-rms, rms, color='k', alpha=0.08, label=f'rms {rms:.3f}°')
    axes.set(xlabel='time [s]', ylabel='heading error [°]')
    _mark_dirt(axes, accuracy)


def _draw_close_up(axes: Axes, accuracy: FloorAccuracy, dots: NDArray[np.float64]) -> None:
    """Draw a piece of the floor around the camera's view, where the drive is half over."""
    index = len(accuracy.truth) // 2
    middle = accuracy.truth.positions[index, :2]
    yaw = Rotation.from_quat(accuracy.truth.quaternions[index]).as_euler('zyx')[0]
    half = VIEW * np.array([2.0, 0.75])
    near = dots[(np.abs(dots - middle) < half).all(axis=1)]
    axes.scatter(near[:, 0], near[:, 1], s=14.0, color=DOTS)
    axes.plot(*accuracy.truth.positions[:, :2].T, color=TRUTH, linewidth=3.0, alpha=0.4)
    axes.plot(*accuracy.errors.estimate.positions[:, :2].T, '.', color=ESTIMATE, markersize=6.0)
    corner = middle + Rotation.from_euler('z', yaw).apply([-VIEW / 2.0, -VIEW / 2.0, 0.0])[:2]
    view = Rectangle(tuple(corner), VIEW, VIEW, angle=math.degrees(yaw), fill=False, color=TRUTH)
    axes.add_patch(view)
    x_limits, y_limits = zip(middle - half, middle + half, strict=True)
    axes.set(aspect='equal', xlim=x_limits, ylim=y_limits, xlabel='x [m]', ylabel='y [m]')
    axes.set_title('Close-up at half time; the frame is what the camera sees at once')


def _mark_dirt(axes: Axes, accuracy: FloorAccuracy) -> None:
    for number, stretch in enumerate(accuracy.dirty_ns):
        first, last = _seconds(accuracy, stretch)
        axes.axvspan(first, last, color=DIRT, alpha=0.25, label='floor hidden by dirt' if number == 0 else None)
    axes.legend(loc='upper left', fontsize='small')
    axes.grid(alpha=0.3)
    duration = _seconds(accuracy, accuracy.images_ns[-1:])[0]
    axes.set_xlim(0.0, duration)


def _seconds(accuracy: FloorAccuracy, stamps_ns: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the time since the first image [s]."""
    return (stamps_ns - accuracy.images_ns[0]) / NANOSECONDS


def _is_dirty(accuracy: FloorAccuracy) -> NDArray[np.bool_]:
    """Tell which images are of hidden floor, shape (n,)."""
    dirty = np.zeros(len(accuracy.images_ns), dtype=np.bool_)
    for start, end in accuracy.dirty_ns:
        dirty |= (start <= accuracy.images_ns) & (accuracy.images_ns <= end)
    return dirty
