"""``calibrate``: a lens or a stereo pair from images of a printed board, with a report; and the board to print."""

import argparse
import base64
import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from importlib.resources import files
from itertools import islice
from pathlib import Path
from time import monotonic
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from shirube_camera.core import calibration as core
from shirube_camera.core.calibration import Board, BoardSettings, BoardView, ShirubeCameraError
from shirube_camera.frame_source import CONTROLS, CameraSettings, Frame, FrameSource
from shirube_core.command import add_settings, run_command, settings_from
from shirube_core.files import write_text
from shirube_core.settings import SettingsError
from shirube_ros.camera.files import calibration_text
from shirube_ros.camera.image import to_grey
from shirube_ros.errors import CameraFileError

_VIDEO_STEP = 5  # of the images of a video, every fifth is searched
Images = list[NDArray[np.uint8]]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 if the images are insufficient or a file is invalid."""
    options = make_parser().parse_args(arguments)
    errors = ShirubeCameraError, CameraFileError, SettingsError
    work = _write_board if options.task == 'board' else _calibrate
    return run_command('calibrate', lambda: work(options), errors, options.out)


def _write_board(options: argparse.Namespace) -> None:
    _write_page(options.out, 'board.html', asdict(settings_from(options, BoardSettings)))
    print(f'{options.out}: print it from a browser at 100 %, measure a square, glue it to a flat plate')


def _write_page(out: Path, name: str, content: dict[str, Any]) -> None:
    page = (files('shirube_camera') / name).read_text()
    write_text(out, page.replace('{{content}}', json.dumps(content).replace('<', '\\u003c')))


def _calibrate(options: argparse.Namespace) -> None:
    board, is_pair = Board(settings_from(options, BoardSettings)), options.task == 'stereo'
    count, names, images, views = 0, list[str](), list[Images](), list[tuple[BoardView, ...]]()
    progress = tqdm(_groups(options), 'images', disable=None)
    for count, (name, group) in enumerate(progress, 1):  # noqa: B007 the number of all
        images = images or [group]
        if any(image.shape != images[0][0].shape for image in group):
            raise ShirubeCameraError(f'{name} has another size; give images of one size')
        seen = [view for view in map(board.detect, group) if view is not None]
        if len(seen) == len(group):
            names, views = [*names, name], [*views, tuple(seen)]
            progress.set_postfix(views=len(views))
    height, width = images[0][0].shape if images else (0, 0)
    chosen = core.select_views(board.corners, [view[0] for view in views], width)
    names, views = [names[k] for k in chosen], [views[k] for k in chosen]
    found: Sequence[core.Calibration]
    if is_pair:
        found = core.calibrate_stereo(board.corners, [(view[0], view[1]) for view in views], (width, height))
    else:
        found = (core.calibrate_lens(board.corners, [view[0] for view in views], (width, height)),)
    lines = [f'{count} images, {len(views)} different ones show the board, {len(found[0].used)} are used']
    lines += map(_summary, found)
    sides = [*zip(found[-len(views[0]) :], zip(*views, strict=True), strict=True)]
    advised = [*dict.fromkeys(each for side in sides for each in core.advice(*side))]
    content: dict[str, Any] = {'lines': lines, 'advice': advised}
    content['lenses'] = [_lens(*side, names) for side in sides]
    calibrated = [*zip(found[0].cameras, found[0].rotations, found[0].projections, strict=True)]
    maps = (camera.rectification_maps(R, P[:, :3]) for camera, R, P in calibrated)
    rectified = [cv2.remap(image, u, v, 1) for image, (u, v) in zip(images[0], maps, strict=True)]
    pictures = [cv2.imencode('.jpg', each)[1].tobytes() for each in rectified]
    content['pictures'] = [base64.b64encode(each).decode() for each in pictures]
    outs = [options.out / f'{side}.yaml' for side in ('left', 'right')] if is_pair else [options.out]
    for out, each in zip(outs, calibrated, strict=True):
        write_text(out, calibration_text(out.stem, *each))
    report = options.out / 'report.html' if is_pair else options.out.with_suffix('.html')
    _write_page(report, 'report.html', content)
    print('\n'.join([*lines, *advised, *map(str, outs), f'{report}: open it in a browser']))


def _groups(options: argparse.Namespace) -> Iterator[tuple[str, Images]]:
    """Yield name and grey image, or name and both images of a pair, whose files may be double images."""
    for frames in zip(*(_frames(name, options) for name in options.sources), strict=False):
        images = [to_grey(frame.pixels) for frame in frames]
        if options.task == 'stereo' and len(images) == 1:
            images = np.array_split(images[0], 2, axis=1)
        yield frames[0].name or 'an image', [np.ascontiguousarray(image) for image in images]


def _frames(name: str, options: argparse.Namespace) -> Iterator[Frame]:
    settings = CameraSettings(name, **{each: getattr(options, each) for each in CONTROLS})
    source, end = FrameSource(settings), monotonic() + options.seconds
    for refused in source.apply(settings):
        print(f'calibrate: {name}: {refused}', file=sys.stderr)
    frames = iter(source.read, None)
    for frame in frames if source.is_live or Path(name).is_dir() else islice(frames, 0, None, _VIDEO_STEP):
        if source.is_live and monotonic() > end:
            break
        yield frame
    source.close()


def _summary(found: core.Calibration) -> str:
    if len(found.cameras) == 2:
        rows = float(np.sqrt((np.concatenate(found.residuals) ** 2).mean()))
        baseline = f'{1e3 * found.parameters[0]:.2f} mm ± {1e3 * found.sigmas[0]:.2f} mm'
        return f'baseline {baseline}, rows of left and right differ by {rows:.2f} px rms'
    rms = float(np.sqrt((found.errors**2).mean()))
    numbers = zip(core.PARAMETERS, found.parameters, found.sigmas, strict=True)
    return ', '.join([f'rms {rms:.3f} px', *(f'{name} {value:.5g} ± {sigma:.2g}' for name, value, sigma in numbers)])


def _lens(lens: core.Calibration, views: Sequence[BoardView], names: Sequence[str]) -> dict[str, Any]:
    camera, errors = lens.cameras[0], dict(zip(lens.used, lens.errors.tolist(), strict=True))
    corners = [np.hstack([views[k].pixels, each]) for k, each in zip(lens.used, lens.residuals, strict=True)]
    shown = [{'name': name, 'error': errors.get(k)} for k, name in enumerate(names)]
    rounded = [each.round(2).tolist() for each in corners]
    return {'width': camera.width, 'height': camera.height, 'corners': rounded, 'views': shown}


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    parser = argparse.ArgumentParser(prog='calibrate', description='Calibrate a lens or a pair by a board.')
    tasks = parser.add_subparsers(dest='task', required=True)
    about = {'lens': 'one camera', 'stereo': 'two, left first, or double images', 'board': 'print it'}
    for task, out in (('lens', 'camera.yaml'), ('stereo', 'stereo'), ('board', 'board.html')):
        each = tasks.add_parser(task, help=about[task])
        if task != 'board':
            text = 'folder of images, video, or camera (number or /dev/...)'
            each.add_argument('sources', nargs='+' if task == 'stereo' else 1, metavar='SOURCE', help=text)
            each.add_argument('--seconds', type=float, default=60.0, help='with a camera (default: 60)')
            add_settings(each, CameraSettings, CONTROLS)
        each.add_argument('--out', type=Path, default=Path(out), help='default: %(default)s')
        add_settings(each, BoardSettings)
    return parser


if __name__ == '__main__':
    sys.exit(main())
