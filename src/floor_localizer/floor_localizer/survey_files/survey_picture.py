"""Plots of a survey: observations of each dot and the path of the robot; the residuals."""

from __future__ import annotations

from typing import BinaryIO

import numpy as np
from matplotlib.figure import Figure

from floor_localizer.core.survey.floor_survey import SurveyResult
from floor_localizer.survey_files.residual_statistics import LengthHistogram

_LONG_SIDE, _MIN_SHORT_SIDE = 9.0, 3.5  # size of the floor in the plot [inch]
_MAX_COUNT = 8
_CELLS = 24


def draw_survey(file: BinaryIO, result: SurveyResult) -> None:
    """Write a PNG of the map: dots coloured by their number of observations, and the path of the robot."""
    points = result.dot_map.points
    size = np.maximum(np.ptp(points, axis=0), 1e-3)
    width, height = np.maximum(_LONG_SIDE * size / size.max(), _MIN_SHORT_SIDE)
    figure = Figure(figsize=(width + 1.6, height + 1.0), layout='constrained')
    axes = figure.add_subplot(aspect='equal', xlabel='x [m]', ylabel='y [m]', title=f'{len(points)} dots')
    area = float(np.clip(3e5 * np.prod(size / size.max()) / len(points) / 20.0, 0.3, 12.0))
    shades = axes.scatter(
        points[:, 0],
        points[:, 1],
        c=np.minimum(result.counts, _MAX_COUNT),
        s=area,
        cmap='viridis',
        vmin=0,
        vmax=_MAX_COUNT,
        linewidths=0,
    )
    axes.plot(
        *result.states[:, :2].T,
        '-',
        color='tab:red',
        linewidth=0.6,
        alpha=0.7,
        label='path of the robot base',
    )
    figure.colorbar(shades, ax=axes, label=f'observations per dot ({_MAX_COUNT} or more: yellow)', shrink=0.7)
    figure.legend(loc='outside lower center')
    figure.savefig(file, format='png', dpi=110)


def draw_residuals(file: BinaryIO, result: SurveyResult) -> None:
    """Write a PNG of the residuals: their rms by position of the robot, and their histogram."""
    points = result.dot_map.points
    figure = Figure(figsize=(11.0, 5.0), layout='constrained')
    left, right = figure.subplots(1, 2)
    drive = result.states[:, :2]
    lower, size = drive.min(axis=0), np.maximum(np.ptp(drive, axis=0), 1e-6)
    counts, squares, component_lengths = np.zeros(_CELLS**2), np.zeros(_CELLS**2), LengthHistogram()
    for image, residuals in result.residuals:
        cells = np.minimum((_CELLS * (drive[image] - lower) / size.max()).astype(int), _CELLS - 1)
        flat = cells[:, 0] * _CELLS + cells[:, 1]
        counts += np.bincount(flat, minlength=_CELLS**2)
        squares += np.bincount(flat, np.sum(residuals**2, axis=1), _CELLS**2)
        component_lengths.add(np.abs(residuals).ravel())
    rms = 1e3 * np.sqrt(squares / np.maximum(2 * counts, 1))
    shown = np.where(counts > 0, rms, np.nan).reshape(_CELLS, _CELLS).T
    extent = (lower[0], lower[0] + size.max(), lower[1], lower[1] + size.max())
    shades = left.imshow(shown, origin='lower', extent=extent, cmap='magma', vmin=0.0)
    left.set(title='rms residual per axis, by position of the robot', xlabel='x [m]', ylabel='y [m]')
    left.set_xlim(points[:, 0].min(), max(points[:, 0].max(), extent[1]))
    left.set_ylim(points[:, 1].min(), max(points[:, 1].max(), extent[3]))
    figure.colorbar(shades, ax=left, label='mm', shrink=0.8)
    bins = np.linspace(-1e3 * component_lengths.quantile(0.997), 1e3 * component_lengths.quantile(0.997), 80)
    each = [np.zeros(len(bins) - 1), np.zeros(len(bins) - 1)]
    for _, residuals in result.residuals:
        for k in range(2):
            each[k] += np.histogram(1e3 * residuals[:, k], bins)[0]
    for k, name in enumerate('xy'):
        right.stairs(each[k], bins, label=name)
    right.set(title='residuals', xlabel='mm', ylabel='observations')
    right.legend()
    figure.savefig(file, format='png', dpi=100)
