"""``build_map``: build a dot map from a drive over the floor, from images and rough odometry."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO

import numpy as np

from floor_localizer.commands.options import add_mount_options, add_worker_options, run_resumable, task_runner
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.mount_check import check_mount
from floor_localizer.core.settings import SurveySettings
from floor_localizer.core.survey.floor_survey import KnownLength, SurveyResult, scale_survey
from floor_localizer.files.dot_map_file import load_dot_map, save_csv
from floor_localizer.survey_files.checkpoint import Checkpoint
from floor_localizer.survey_files.survey_report import (
    LengthHistogram,
    save_image_poses,
    save_observation_counts,
    survey_report,
)
from floor_localizer.survey_files.survey_run import SurveyRun, run_survey, survey_inputs
from floor_localizer.survey_files.survey_source import BagSource, FolderSource
from shirube_bags.errors import ShirubeBagsError
from shirube_core.command import add_settings, settings_from
from shirube_core.files import atomic_write, exclusive_lock, remove_temporary_files, write_text
from shirube_core.geometry import CameraMount

RESULTS = ('observations.csv', 'images.csv', 'report.txt', 'map.png', 'residuals.png', 'map.csv')
"""Files that are written; the map is the last."""
_LONG_SIDE, _MIN_SHORT_SIDE = 9.0, 3.5  # size of the floor in the plot [inch]
_MAX_COUNT = 8
_CELLS = 24


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, 1 when the drive cannot be surveyed or a file is bad, 130 when it is interrupted."""
    options = make_parser().parse_args(arguments)
    return run_resumable('build_map', lambda: build_map(options), options.out, (ShirubeBagsError,))


def build_map(options: argparse.Namespace) -> None:
    """Make the map and write all results."""
    settings = settings_from(options, SurveySettings)
    mount = CameraMount(tuple(options.camera_xyz), tuple(options.camera_rpy))
    check_mount(mount)
    if options.extend is not None and options.known_length is not None:
        raise FloorLocalizerError('--known-length: the map given by --extend already has a scale; give one of both')
    existing = None if options.extend is None else load_dot_map(options.extend)
    source = open_source(options)
    key = survey_inputs(source, mount, settings, existing)
    folder = options.out / 'checkpoint'
    with exclusive_lock(folder, file='lock', wait=False):
        checkpoint = Checkpoint(folder, key)
        with task_runner(options.workers, options.scheduler) as runner:
            run = run_survey(source, mount, settings, checkpoint, runner, existing)
        write_results(options, run)
        checkpoint.remove_stores()


def open_source(options: argparse.Namespace) -> FolderSource | BagSource:
    """Return the image source given by the options."""
    if options.bag is not None:
        return BagSource(options.bag, options.topic, options.camera_info_topic, options.odom_topic)
    for name in ('calibration', 'odometry'):
        if getattr(options, name) is None:
            raise FloorLocalizerError(f'--{name} is missing; a folder of images needs it')
    return FolderSource(options.images, options.calibration, options.odometry)


def write_results(options: argparse.Namespace, run: SurveyRun) -> None:
    """Write map, tables, report and plots, each file atomically."""
    scale = None
    if options.known_length is not None:
        x1, y1, x2, y2, length = options.known_length
        known = KnownLength(np.array([x1, y1]), np.array([x2, y2]), length)
        result, scale = scale_survey(run.result, known)
        run = SurveyRun(result, run.images, run.faults)
    out: Path = options.out
    for name in RESULTS:
        remove_temporary_files(out, name)
    report = survey_report(run, scale)
    save_observation_counts(out / 'observations.csv', run.result)
    save_image_poses(out / 'images.csv', run)
    write_text(out / 'report.txt', report + '\n')
    for name, draw in (('map.png', draw_survey), ('residuals.png', draw_residuals)):
        with atomic_write(out / name) as file:
            draw(file, run.result)
    save_csv(out / 'map.csv', run.result.dot_map)
    print(report)
    print(f'{out / "map.csv"}: the map; plots and tables are in the same folder')


def draw_survey(file: BinaryIO, result: SurveyResult) -> None:
    """Write a PNG of the map: dots coloured by their number of observations, and the path of the robot."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - takes half a second, only the plot needs it

    points = result.dot_map.points
    size = np.maximum(np.ptp(points, axis=0), 1e-3)
    width, height = np.maximum(_LONG_SIDE * size / size.max(), _MIN_SHORT_SIDE)
    figure = Figure(figsize=(width + 1.6, height + 1.0), layout='constrained')
    axes = figure.add_subplot(aspect='equal', xlabel='x [m]', ylabel='y [m]', title=f'{len(points)} dots')
    area = float(np.clip(3e5 * np.prod(size / size.max()) / len(points) / 20.0, 0.3, 12.0))
    counts = np.minimum(result.counts, _MAX_COUNT)
    x, y = points.T
    shades = axes.scatter(x, y, area, counts, cmap='viridis', vmin=0, vmax=_MAX_COUNT, linewidths=0)
    axes.plot(*result.states[:, :2].T, '-', color='tab:red', linewidth=0.6, alpha=0.7, label='path of the robot base')
    figure.colorbar(shades, ax=axes, label=f'observations per dot ({_MAX_COUNT} or more: yellow)', shrink=0.7)
    figure.legend(loc='outside lower center')
    figure.savefig(file, format='png', dpi=110)


def draw_residuals(file: BinaryIO, result: SurveyResult) -> None:
    """Write a PNG of the residuals: their rms by position of the robot, and their histogram."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - takes half a second, only the plot needs it

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


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    parser = argparse.ArgumentParser(
        prog='build_map',
        description='Build a dot map from a drive over the floor. The same command resumes an interrupted survey.',
    )
    add = parser.add_argument
    drive = parser.add_mutually_exclusive_group(required=True)
    drive.add_argument('--bag', type=Path, help='rosbag2 with images, camera_info and odometry')
    drive.add_argument('--images', type=Path, metavar='FOLDER', help='images, sorted by name')
    add('--calibration', type=Path, metavar='YAML', help='calibration of the images, as camera_calibration writes it')
    add('--odometry', type=Path, metavar='FILE',
        help='odometry of the images: CSV "image,x,y,yaw", or TUM with one line per image')  # fmt: skip
    add('--topic', help='image topic of the bag (default: /image_raw or the only one)')
    add(
        '--camera-info-topic',
        metavar='TOPIC',
        help='camera_info topic of the bag (default: /camera_info or the only one)',
    )
    add('--odom-topic', metavar='TOPIC', help='odometry topic of the bag (default: /odom or the only one)')
    add(
        '--extend',
        type=Path,
        metavar='MAP',
        help='dot map to extend, on which the drive begins; its dots keep their positions',
    )
    add('--known-length', type=float, nargs=5, metavar=('X1', 'Y1', 'X2', 'Y2', 'LENGTH'),
        help='positions of two dots in the map without this option, and their true distance [m]')  # fmt: skip
    add('--out', type=Path, default=Path('out/survey'), metavar='FOLDER', help='default: %(default)s')
    add_mount_options(
        parser,
        'position of the optical frame in the base frame [m] (default: %(default)s)',
        'fixed-axis roll, pitch, yaw of the optical frame [rad] (default: looking down)',
    )
    add_worker_options(parser)
    add_settings(parser, SurveySettings)
    return parser


if __name__ == '__main__':
    sys.exit(main())
