"""``calibrate``: a lens or a stereo pair from images of a printed board, with a report; and the board to print."""

from __future__ import annotations

import argparse
import base64
import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from itertools import islice
from pathlib import Path
from time import monotonic
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from shirube_camera.core.board import MODULES, Board, BoardSettings, BoardView, ShirubeCameraError
from shirube_camera.core.calibration import PARAMETERS, Calibration, calibrate_lens, calibrate_stereo
from shirube_camera.core.coverage import advice, select_views
from shirube_camera.frame_source import Frame, FrameSource
from shirube_camera.node_settings import CameraNodeSettings
from shirube_core.command import add_settings, run_command, settings_from
from shirube_core.files import write_text
from shirube_core.settings import SettingsError
from shirube_ros.camera.files import calibration_text
from shirube_ros.camera.image import to_grey
from shirube_ros.errors import CameraFileError

_VIDEO_STEP = 5  # of the images of a video, every fifth is searched


@dataclass
class Views:
    """Images that show the board: their names, the first of them, and the corners in one or two images of each."""

    total: int = 0
    names: list[str] = field(default_factory=list)
    images: list[NDArray[np.uint8]] = field(default_factory=list)
    corners: list[tuple[BoardView, ...]] = field(default_factory=list)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 if the images are insufficient or a file is invalid."""
    options = make_parser().parse_args(arguments)
    work = print_board if options.task == 'board' else calibrate
    return run_command(
        'calibrate', lambda: work(options), (ShirubeCameraError, CameraFileError, SettingsError), options.out
    )


def calibrate(options: argparse.Namespace) -> None:
    """Calibrate, write the calibrations and the report, and print what was found."""
    board, is_pair = Board(settings_from(options, BoardSettings)), options.task == 'stereo'
    views = _find_views(options, board, is_pair)
    size = views.images[0].shape[1::-1] if views.images else (1, 1)
    chosen = select_views(board.corners, [each[0] for each in views.corners], size[0])
    corners, names = [views.corners[k] for k in chosen], [views.names[k] for k in chosen]
    sides = [list(side) for side in zip(*corners, strict=True)] or [[]]
    found = (
        calibrate_stereo(board.corners, list(zip(*sides, strict=True)) if is_pair and corners else [], size)
        if is_pair
        else (calibrate_lens(board.corners, sides[0], size),)
    )
    lenses = found[-len(sides) :]
    advised = [
        f'{sentence}' for lens, side in zip(lenses, sides, strict=True) for sentence in advice(lens, side)
    ]
    lines = [f'{views.total} images, {len(views.names)} show the board, {len(found[0].used)} views used']
    lines += [line for each in found for line in _summary(each)]
    outs = [options.out / f'{side}.yaml' for side in ('left', 'right')] if is_pair else [options.out]
    for out, *calibrated in zip(
        outs, found[0].cameras, found[0].rotations, found[0].projections, strict=True
    ):
        write_text(out, calibration_text(out.stem, *calibrated))
    report = (options.out / 'report' if is_pair else options.out).with_suffix('.html')
    content = {
        'lines': lines,
        'advice': list(dict.fromkeys(advised)),
        'pictures': _pictures(found[0], views.images),
    }
    content['lenses'] = [_lens(lens, side, names) for lens, side in zip(lenses, sides, strict=True)]
    page = (files('shirube_camera') / 'report.html').read_text()
    write_text(report, page.replace('{{content}}', json.dumps(content).replace('<', '\\u003c')))
    print('\n'.join([*lines, *content['advice'], *map(str, outs), f'{report}: open it in a browser']))


def _find_views(options: argparse.Namespace, board: Board, is_pair: bool) -> Views:
    views = Views()
    frames = [_frames(name, options.seconds) for name in options.sources]
    for group in zip(*frames, strict=False):
        images = [to_grey(frame.pixels) for frame in group]
        if is_pair and len(images) == 1:
            images = np.array_split(images[0], 2, axis=1)
        images, views.total = [np.ascontiguousarray(image) for image in images], views.total + 1
        for image in images:
            if image.shape != (views.images or images)[0].shape:
                raise ShirubeCameraError(f'image {views.total} has another size; give images of one size')
        found = [board.detect(image) for image in images]
        if all(each is not None for each in found):
            views.names.append(group[0].name or f'image {views.total}')
            views.images = views.images or images
            views.corners.append(tuple(each for each in found if each is not None))
            if sys.stderr.isatty():
                print(f'{len(views.names)} views of the board', end='\r', file=sys.stderr)
    return views


def _frames(name: str, seconds: float) -> Iterator[Frame]:
    source = FrameSource(CameraNodeSettings(device=name))
    end = monotonic() + seconds
    frames = iter(source.read, None)
    for frame in frames if source.is_live or Path(name).is_dir() else islice(frames, 0, None, _VIDEO_STEP):
        if source.is_live and monotonic() > end:
            break
        yield frame
    source.close()


def _summary(found: Calibration) -> list[str]:
    rms = float(np.sqrt((found.errors**2).mean()))
    if len(found.cameras) == 2:
        rows = float(np.sqrt((np.concatenate(found.residuals) ** 2).mean()))
        baseline = f'{1e3 * found.parameters[0]:.2f} mm ± {1e3 * found.sigmas[0]:.2f} mm'
        return [f'baseline {baseline}, rows of left and right differ by {rows:.2f} px rms']
    pairs = zip(PARAMETERS, found.parameters, found.sigmas, strict=True)
    return [
        f'rms {rms:.3f} px; ' + ', '.join(f'{name} {value:.5g} ± {sigma:.2g}' for name, value, sigma in pairs)
    ]


def _lens(lens: Calibration, views: Sequence[BoardView], names: Sequence[str]) -> dict[str, Any]:
    camera, errors = lens.cameras[0], dict(zip(lens.used, lens.errors.tolist(), strict=True))
    corners = [
        np.column_stack([views[k].pixels, residual]).round(2).tolist()
        for k, residual in zip(lens.used, lens.residuals, strict=True)
    ]
    shown = [{'name': name, 'error': errors.get(k)} for k, name in enumerate(names)]
    return {'width': camera.width, 'height': camera.height, 'corners': corners, 'views': shown}


def _pictures(found: Calibration, images: Sequence[NDArray[np.uint8]]) -> list[str]:
    """Return the first images undistorted and rectified, as JPEG in base64."""
    maps = [
        camera.rectification_maps(R, P[:, :3])
        for camera, R, P in zip(found.cameras, found.rotations, found.projections, strict=True)
    ]
    pictures = [cv2.remap(image, *uv, cv2.INTER_LINEAR) for image, uv in zip(images, maps, strict=True)]
    return [_encoded('.jpg', each) for each in pictures]


def _encoded(form: str, image: NDArray[np.uint8]) -> str:
    return base64.b64encode(cv2.imencode(form, image)[1].tobytes()).decode()


def print_board(options: argparse.Namespace) -> None:
    """Write the board as an SVG at true scale, with a white margin of one square."""
    settings = settings_from(options, BoardSettings)
    modules = Board(settings).modules()
    side, (height, width) = (
        1e3 * settings.square,
        (1e3 * settings.square / MODULES * np.array(modules.shape)).tolist(),
    )
    about = f'{settings.pattern}, {settings.columns} x {settings.rows} inner corners, square {side:g} mm: measure it'
    pixels = np.kron(np.where(modules, 0, 255), np.ones((20, 20))).astype(np.uint8)
    size = f'width="{width + 2.0 * side:g}mm" height="{height + 2.0 * side:g}mm"'
    write_text(
        options.out,
        f'<svg xmlns="http://www.w3.org/2000/svg" {size}><image x="{side:g}mm" y="{side:g}mm" width="{width:g}mm" '
        f'height="{height:g}mm" href="data:image/png;base64,{_encoded(".png", pixels)}"/><text x="{side:g}mm" '
        f'y="{0.6 * side:g}mm" font-size="4mm">{about}</text></svg>\n',
    )
    print(f'{options.out}: {about}; print at 100 % and glue it to a flat plate')


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    parser = argparse.ArgumentParser(
        prog='calibrate', description='Calibrate a lens or a stereo pair by a board.'
    )
    tasks = parser.add_subparsers(dest='task', required=True)
    about = {
        'lens': 'one camera',
        'stereo': 'two cameras, the left one first, or one of both halves',
        'board': 'print it',
    }
    for task, out in (('lens', 'camera.yaml'), ('stereo', 'stereo'), ('board', 'board.svg')):
        each = tasks.add_parser(task, help=about[task])
        if task != 'board':
            text = 'folder of images, video, or camera (number or /dev/...)'
            each.add_argument('sources', nargs='+' if task == 'stereo' else 1, metavar='SOURCE', help=text)
            each.add_argument(
                '--seconds', type=float, default=60.0, help='of a camera (default: %(default)s)'
            )
        each.add_argument('--out', type=Path, default=Path(out), help='default: %(default)s')
        add_settings(each, BoardSettings)
    return parser


if __name__ == '__main__':
    sys.exit(main())
