"""Opens the teaching page for a source of images."""

from __future__ import annotations

import argparse
from pathlib import Path

from shirube_geometry import CameraMount
from shirube_ros.image_files import list_images
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.teaching_state import TeachingState
from stereo_landmark.files.calibration_file import load_camera_calibration
from stereo_landmark.page.access import is_loopback, new_token
from stereo_landmark.page.page_answers import PageAnswers
from stereo_landmark.page.page_server import PageServer, serve
from stereo_landmark.page.pair_source import FilePairs, PairSource
from stereo_landmark.page.place_saver import PlaceSaver

PORT = 8765


def add_page_options(parser: argparse.ArgumentParser) -> None:
    """Add what only the page needs."""
    add = parser.add_argument
    add('--name', default='place_1', help='of the place, to begin with (default: %(default)s)')
    add(
        '--host',
        default='127.0.0.1',
        help='address to listen on; any but this machine only asks for a token (default: %(default)s)',
    )
    add('--port', type=int, default=PORT, help='0 for any that is free (default: %(default)s)')
    add('--tilt', type=float, nargs=2, default=(0.0, 0.0), metavar=('ROLL', 'PITCH'),
        help='of the robot on images [rad] (default: level)')  # fmt: skip


def open_page(source: PairSource, folder: Path, options: argparse.Namespace) -> None:
    """Serve the page until Ctrl-C.

    Args:
        source: of the pairs of images.
        folder: where places are saved.
        options: of `add_page_options`.

    Raises:
        StereoLandmarkError: the first pair cannot be used.
        OSError: the address cannot be listened on.
    """
    token = '' if is_loopback(options.host) else new_token()
    answers = PageAnswers(source, PlaceSaver(folder), TeachingState(name=options.name))
    source.images(answers.session.state.pair)

    def say(port: int) -> None:
        query = f'/?token={token}' if token else '/'
        host = f'[{options.host}]' if ':' in options.host else options.host
        print(f'The teaching page is at http://{host}:{port}{query} (Ctrl-C ends it)', flush=True)  # noqa: T201

    serve(PageServer(answers, token), options.host, options.port, say)


def files_source(options: argparse.Namespace) -> FilePairs:
    """Return the pairs of image files that options name.

    Raises:
        StereoLandmarkError: files are missing, or the calibrations are no pair's.
        CameraFileError: a file cannot be used.
    """
    if not (options.right and options.left_calibration and options.right_calibration):
        raise StereoLandmarkError('--left needs --right, --left-calibration and --right-calibration')
    left, right = list_images(options.left), list_images(options.right)
    if len(left) != len(right):
        raise StereoLandmarkError(
            f'there are {len(left)} left and {len(right)} right images; give pairs in the same order'
        )
    calibrations = (
        load_camera_calibration(options.left_calibration),
        load_camera_calibration(options.right_calibration),
    )
    mount = CameraMount(tuple(options.camera_xyz), tuple(options.camera_rpy))
    return FilePairs(
        list(zip(left, right, strict=True)),
        calibrations,
        mount,
        rectify=options.rectify,
        tilt=tuple(options.tilt),
    )
