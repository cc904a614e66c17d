"""``teach``: teaches a place from stereo images, on a page in the browser or from a config file."""

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from shirube_bags.errors import ShirubeBagsError
from shirube_core.command import run_command
from shirube_core.settings import SettingsError
from shirube_ros.errors import CameraFileError
from shirube_ros.offline.locate import add_mount_options
from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer, NoLandmarkFix
from stereo_landmark.core.procedure.stereo_view import StereoView, detect_scene
from stereo_landmark.core.procedure.target_search import NoTargetDetection
from stereo_landmark.core.settings import SHAPES, LandmarkSettings, PlaceSettings
from stereo_landmark.core.stereo import SpatialPoints
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.hints import report_target
from stereo_landmark.core.teaching.primitive_selection import TargetSelection, select_primitives
from stereo_landmark.core.teaching.teacher import Teacher
from stereo_landmark.files.camera_files import add_pair_options
from stereo_landmark.files.place_file import place_path, save_place
from stereo_landmark.files.teach_config_file import TargetConfig, load_pair, load_teach_config
from stereo_landmark.node_settings import NodeSettings
from stereo_landmark.page.teach_page import open_page

_NODE = NodeSettings()
_PORT, _PORT_MAX = 8765, 65535


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 if the place cannot be taught."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    own = given[: given.index('--ros-args')] if '--ros-args' in given else given
    parser = make_parser()
    options = parser.parse_args(own, argparse.Namespace(ros_args=given[len(own) :]))
    if options.accept and options.drive is None:
        parser.error('--accept goes with --drive')
    if options.batch is not None:
        work = partial(teach_batch, options.batch, options.places, replace=options.replace)
    else:
        work = partial(open_page, options)
    errors = (StereoLandmarkError, CameraFileError, ShirubeBagsError, SettingsError)
    try:
        return run_command('teach', work, errors, options.places)
    except KeyboardInterrupt:
        return 0


def teach_batch(path: Path, places: Path, *, replace: bool = False) -> None:
    """Teach the place of a teach config, save it and print warnings (paper 4, fig. 9).

    Raises:
        StereoLandmarkError: the config is invalid, or the place exists and must not be replaced.
    """
    config = load_teach_config(path)
    file = place_path(places, config.name)
    if file.exists() and not replace:
        raise StereoLandmarkError(f'{file} exists; give --replace, or another name')
    # (a) Image processing: the primitives of the rectified pair.
    images, rig, check = load_pair(config)
    print(check.summary)
    left, right = (detect_scene(image, config.processing) for image in (images.left, images.right))
    teacher = Teacher(StereoView(left, right, rig, images.tilt), config.processing)
    # (b) Targets: primitives in their order of detection; (c) corresponding points with their 3D coordinates.
    selections, refused = teacher.drop_refused(_select_target(target, teacher) for target in config.targets)
    place = teacher.teach(config.name, selections, config.T_map_place)
    # (d) Procedure tree: the place must be recognized in its own images.
    settings = LandmarkSettings(method=SHAPES)  # features would find any place
    answer = LandmarkLocalizer([place], settings).locate(images.left, images.right, images.tilt)
    if file.exists() and isinstance(answer, NoLandmarkFix):
        raise StereoLandmarkError(
            f'{place.name} is not recognized in its own images: {answer.reason} ({answer.detail}); '
            f'{file} is kept, teach other targets'
        )
    saved = save_place(places, place, images, replace_damaged=replace)
    _print_points(place.coordinates)
    for line in (*refused, *undetected_targets(answer), *_selection_warnings(selections, teacher)):
        print(f'warning: {line}')
    print(f'{place.name} is taught, with {len(place.context_landmarks)} context landmarks; see {saved}')


def _select_target(target: TargetConfig, teacher: Teacher) -> TargetSelection:
    scene = teacher.with_processing(target.processing).view.left
    try:
        chosen = select_primitives(target.selections, scene)
        return TargetSelection(target.name, chosen, target.points, processing=target.processing)
    except StereoLandmarkError as fault:
        raise StereoLandmarkError(f'target {target.name}: {fault}') from fault


def _print_points(points: SpatialPoints) -> None:
    for name, position, covariance in zip(points.names, points.positions, points.covariances, strict=True):
        x, y, z = position
        sigma = 1e3 * float(np.sqrt(np.linalg.eigvalsh(covariance)[-1]))
        print(f'{name:<40} x {x:7.3f} m, y {y:7.3f} m, z {z:7.3f} m, +- {sigma:.1f} mm')


def undetected_targets(answer: LandmarkFix | NoLandmarkFix) -> list[str]:
    """Return a line for each target that is not detected in the images used for teaching, by their result."""
    undetected = [
        f'target {detection.target}: {detection.reason.value} even in the taught images ({detection.detail}); '
        'add primitives that distinguish it from similar objects'
        for detection in answer.detections
        if isinstance(detection, NoTargetDetection)
    ]
    if isinstance(answer, NoLandmarkFix) and not undetected:
        undetected.append(f'{answer.reason} even in the taught images ({answer.detail}); select other points')
    return undetected


def _selection_warnings(selections: Sequence[TargetSelection], teacher: Teacher) -> Iterator[str]:
    """Yield the hints of the page, one line each."""
    for selection in selections:
        own = teacher.with_processing(selection.processing)
        report = report_target(selection, selection.primitives, own, PlaceSettings())
        yield from (f'target {hint.target}: {hint.text}' for hint in report.hints)


def make_parser() -> argparse.ArgumentParser:
    """Return the argument parser."""
    parser = argparse.ArgumentParser(
        prog='teach',
        description='Teach a place: select the objects to detect and measure them. Opens a page for the browser; with '
        '--batch it uses a config file and prints warnings about the place.',
    )
    add = parser.add_argument
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument('--batch', type=Path, metavar='FILE', help='teach config (YAML); opens no page')
    source.add_argument(
        '--left', type=Path, nargs='+', help='folder of left images, or left images; the first pair is taught'
    )
    source.add_argument('--bag', type=Path, help='rosbag2 with images, camera_info and optional imu')
    source.add_argument('--drive', type=Path, metavar='BAG',
        help='rosbag2 of a short drive around the place; proposes shapes that are found again for the page or --accept',
    )  # fmt: skip
    source.add_argument('--place', type=Path, metavar='YAML', help='taught place to edit')
    source.add_argument(
        '--live', action='store_true', help='subscribe to left/image_rect and so on; --ros-args may follow'
    )
    add('--places', type=Path, default=Path('places'), metavar='FOLDER', help='default: %(default)s')
    add('--replace', action='store_true', help='allow --batch or --accept to replace a place of the same name')
    add('--accept', action='store_true', help='save what --drive proposes, without the page')
    _add_page_options(parser)
    return parser


def _add_page_options(parser: argparse.ArgumentParser) -> None:
    add_pair_options(parser)
    add_mount_options(parser, _NODE, 'looking ahead')
    add: Callable[..., object] = parser.add_argument
    add('--test-bag', type=Path, nargs='+', default=(), metavar='BAG',
        help='further bags of the same cameras, for tests')  # fmt: skip
    add('--image-transport', default=_NODE.image_transport, choices=('raw', 'compressed', 'auto'),
        help='image transport of live images (default: %(default)s)')  # fmt: skip
    add('--name', default='place_1', help='initial name of the place (default: %(default)s)')
    add('--host', default='127.0.0.1',
        help='listening address; non-loopback addresses require a token (default: %(default)s)')  # fmt: skip
    add('--port', type=_port, default=_PORT, help='port, 0 for any free port (default: %(default)s)')


def _port(text: str) -> int:
    """Parse a port number; raise ArgumentTypeError if it is not a valid port."""
    try:
        port = int(text)
    except ValueError:
        port = -1
    if not 0 <= port <= _PORT_MAX:
        raise argparse.ArgumentTypeError(f'{text} is not a port; choose 0 to {_PORT_MAX}')
    return port


if __name__ == '__main__':
    sys.exit(main())
