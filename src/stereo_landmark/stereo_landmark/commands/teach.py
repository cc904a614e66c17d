"""``teach``: the page on which an engineer teaches a place."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from shirube_bags.errors import ShirubeBagsError
from shirube_ros.file_errors import CameraFileError
from shirube_settings import SettingsError
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.node_settings import NodeSettings
from stereo_landmark.page.teach_page import add_page_options, files_source, open_page

_NODE = NodeSettings()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 when a file is bad."""
    options = make_parser().parse_args(arguments)
    try:
        open_page(files_source(options), options.places, options)
    except (StereoLandmarkError, CameraFileError, ShirubeBagsError, SettingsError) as fault:
        print(f'teach: {fault}', file=sys.stderr)
        return 1
    except OSError as fault:
        print(f'teach: {fault.strerror}; choose another --host or --port', file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        pass
    return 0


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    parser = argparse.ArgumentParser(
        prog='teach',
        description='Teach a place in a browser: which objects to look for, and by which points.',
    )
    add = parser.add_argument
    add('--places', type=Path, required=True, metavar='FOLDER', help='where taught places are kept')
    add(
        '--left',
        type=Path,
        nargs='+',
        required=True,
        help='a folder of left images, or images; the first pair is taught',
    )
    add('--right', type=Path, nargs='+', help='the right images, in the same order')
    for side in ('left', 'right'):
        add(
            f'--{side}-calibration',
            type=Path,
            metavar='YAML',
            help='of the images, as camera_calibration writes it',
        )
    add('--rectify', action='store_true', help='the images are raw')
    add('--camera-xyz', type=float, nargs=3, default=_NODE.camera_xyz, metavar=('X', 'Y', 'Z'),
        help='left optical frame in the base frame [m] (default: %(default)s)')  # fmt: skip
    add('--camera-rpy', type=float, nargs=3, default=_NODE.camera_rpy, metavar=('R', 'P', 'Y'),
        help='its fixed-axis roll, pitch, yaw there [rad] (default: looking ahead)')  # fmt: skip
    add_page_options(parser)
    return parser


if __name__ == '__main__':
    sys.exit(main())
