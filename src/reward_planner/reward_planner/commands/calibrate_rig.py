"""``calibrate_rig``: three cameras in an L from images of a chessboard, as calibrations with a common rectification."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from reward_planner.core.depth.rig_calibration import calibrate_rig, misalignment
from reward_planner.core.reward_planner_error import RewardPlannerError
from shirube_core.files import write_text
from shirube_ros.camera.files import calibration_text, list_images, load_image
from shirube_ros.camera.image import to_grey
from shirube_ros.errors import CameraFileError

_NAMES = ('left', 'right', 'top')


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 if the images are insufficient or a file is invalid."""
    options = make_parser().parse_args(arguments)
    try:
        print('\n'.join(calibrate(options)))
    except (RewardPlannerError, CameraFileError) as fault:
        print(f'calibrate_rig: {fault}', file=sys.stderr)
    except OSError as fault:
        print(f'calibrate_rig: {fault.filename}: {fault.strerror}; choose a writable path', file=sys.stderr)
    else:
        return 0
    return 1


def calibrate(options: argparse.Namespace) -> list[str]:
    """Calibrate, write the files and return the report."""
    columns, rows = options.board
    if min(columns, rows) < 3 or not 0.0 < options.square < 1.0:
        raise RewardPlannerError('--board: give at least 3 x 3 inner corners, and --square in metres')
    folders = [list_images([options.images / name]) for name in _NAMES]
    if len({len(files) for files in folders}) > 1:
        counts = ', '.join(f'{name} {len(files)}' for name, files in zip(_NAMES, folders, strict=True))
        raise RewardPlannerError(
            f'{options.images}: numbers of images differ ({counts}); give one of each camera per view'
        )
    views, size = _find_views(list(zip(*folders, strict=True)), (columns, rows))
    grid = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1)
    cameras = calibrate_rig(options.square * grid.reshape(-1, 2), views, size)
    for name, camera in zip(_NAMES, cameras, strict=True):
        text = calibration_text(name, camera.camera, camera.rotation, camera.projection)
        write_text(options.out / f'{name}.yaml', text)
    row, column = misalignment(cameras, [np.concatenate(seen) for seen in zip(*views, strict=True)])
    (_, right, top), f = (camera.projection[:, 3] for camera in cameras), cameras[0].projection[0, 0]
    return [
        f'{len(views)} of {len(folders[0])} views show the board in all images',
        f'baselines {abs(right[0] / f):.4f} m and {abs(top[1] / f):.4f} m, focal length {f:.1f} px',
        f'corners differ by {row:.3f} px rms in rows of left and right, {column:.3f} px in columns of left and top',
        f'{options.out}: {", ".join(f"{name}.yaml" for name in _NAMES)}',
    ]


def _find_views(
    files: Sequence[tuple[Path, ...]], board: tuple[int, int]
) -> tuple[list[list[NDArray[np.float64]]], tuple[int, int]]:
    """Return the corners of the views in which all cameras see the board, and width and height of the images."""
    views, size = [], (0, 0)
    for view in files:
        images = [to_grey(load_image(path)) for path in view]
        height, width = images[0].shape
        size = size if any(size) else (width, height)
        if any(image.shape != size[::-1] for image in images):
            raise RewardPlannerError(f'{view[0]}: its view has images of another size; give all in one size')
        corners = [_find_corners(image, board) for image in images]
        found = [each for each in corners if each is not None]
        if len(found) == len(_NAMES):
            views.append(found)
    return views, size


def _find_corners(image: NDArray[np.uint8], board: tuple[int, int]) -> NDArray[np.float64] | None:
    """Return the inner corners of a chessboard [px], shape (n, 2), or None."""
    flags = cv2.CALIB_CB_ACCURACY
    is_found, corners = cv2.findChessboardCornersSB(image, board, flags=flags)
    return np.asarray(corners, dtype=np.float64).reshape(-1, 2) if is_found else None


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    parser = argparse.ArgumentParser(
        prog='calibrate_rig',
        description='Calibrate three cameras in an L (left, right, top) from images of a chessboard.',
    )
    add, default = parser.add_argument, '(default: %(default)s)'
    add('images', type=Path, metavar='FOLDER', help='with left/, right/ and top/, same views by name')
    add('--board', type=int, nargs=2, default=(9, 6), metavar='N', help=f'columns, rows of inner corners {default}')
    add('--square', type=float, required=True, metavar='M', help='side of a square [m]')
    add('--out', type=Path, default=Path('rig'), metavar='FOLDER', help=f'of the calibrations {default}')
    return parser


if __name__ == '__main__':
    sys.exit(main())
