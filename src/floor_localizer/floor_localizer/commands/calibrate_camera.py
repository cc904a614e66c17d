"""``calibrate_camera``: height, tilt and pixel scale of the belly camera from an image of a printed mat."""

import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import yaml

from floor_localizer.commands.options import add_mount_options, run_command
from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.mat.camera_calibration import CameraCalibration, calibrate
from floor_localizer.core.mat.mount_fit import KnownHeight
from floor_localizer.files.dot_map_file import load_dot_map
from shirube_core.files import write_text
from shirube_core.geometry import SE2, CameraMount, PinholeCamera
from shirube_ros.camera.files import calibration_text, load_calibration, load_image

# Standard deviation of a height measured with a ruler; the optical centre is somewhere inside the lens [m].
_RULER_SIGMA = 0.002
# Initial focal length for a field of view of 53 degrees, relative to the image size.
_INITIAL_FOCAL_LENGTH = 1.0


def save_mount(path: Path, mount: CameraMount, notes: Sequence[str]) -> None:
    """Write ``camera_xyz`` and ``camera_rpy`` as the node's parameter file below comment lines; raises `OSError`."""
    parameters = {
        'camera_xyz': [round(value, 6) for value in mount.xyz],
        'camera_rpy': [round(value, 6) for value in mount.rpy],
    }
    content = {'/**': {'ros__parameters': parameters}}
    head = ''.join(f'# {note}\n' for note in notes)
    write_text(path, head + yaml.safe_dump(content, sort_keys=False, default_flow_style=None))


def save_intrinsics(path: Path, camera: PinholeCamera) -> None:
    """Write the intrinsics, atomically; raises `OSError`."""
    P = np.column_stack([camera.matrix, np.zeros(3)])
    write_text(path, calibration_text('belly_camera', camera, np.eye(3), P))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 when a file is invalid or the image is insufficient."""
    options = make_parser().parse_args(arguments)
    return run_command('calibrate_camera', lambda: calibrate_and_save(options))


def calibrate_and_save(options: argparse.Namespace) -> None:
    """Calibrate, write the files and print the report."""
    found = calibrate_camera(options)
    lines = report(found, options)
    save_mount(options.out, found.mount, lines)
    if options.calibration is None:
        save_intrinsics(intrinsics_path(options.out), found.fit.camera)
        lines.append(f'{intrinsics_path(options.out)}: the focal length for this height')
    print('\n'.join([*lines, f'{options.out}: camera_xyz and camera_rpy, for --params-file']))


def calibrate_camera(options: argparse.Namespace) -> CameraCalibration:
    """Return the calibration from the image."""
    mat, image = load_dot_map(options.mat), load_image(options.image)
    height, width = image.shape[:2]
    if options.calibration is not None:
        camera = load_calibration(options.calibration)
        if (width, height) != (camera.width, camera.height):
            raise FloorLocalizerError(
                f'{options.image}: is {width} x {height} px, the calibration is for '
                f'{camera.width} x {camera.height} px; calibrate at this resolution'
            )
    else:
        focal = _INITIAL_FOCAL_LENGTH * max(width, height)
        camera = PinholeCamera(width, height, focal, focal, 0.5 * (width - 1), 0.5 * (height - 1))
    if options.height is not None and options.height <= 0.0:
        raise FloorLocalizerError(f'--height: {options.height:g} m is not above the floor; measure from floor to lens')
    return calibrate(
        DotDetector().detect(image),
        mat,
        camera,
        CameraMount(tuple(options.camera_xyz), tuple(options.camera_rpy)),
        focal_length_known=options.calibration is not None,
        known_height=None if options.height is None else KnownHeight(options.height, _RULER_SIGMA),
        T_mat_base=None if options.robot_at is None else SE2(*options.robot_at),
    )


def intrinsics_path(out: Path) -> Path:
    """Return the path of the fitted intrinsics."""
    return out.with_name(f'{out.stem}_intrinsics.yaml')


def report(found: CameraCalibration, options: argparse.Namespace) -> list[str]:
    """Return the report as lines of text."""
    fit, xyz = found.fit, found.mount.xyz
    rpy = ', '.join(f'{math.degrees(angle):.2f}' for angle in found.mount.rpy)
    lines = [
        f'{fit.dots} matched dots, rms reprojection error {fit.residual:.3f} px',
        f'height {1e3 * xyz[2]:.3f} mm ± {1e3 * found.sigma_height:.3f} mm',
        f'tilt {math.degrees(found.tilt):.3f}° ± {math.degrees(found.sigma_tilt):.3f}° (roll, pitch, yaw {rpy}°)',
        f'pixel {1e3 * found.pixel:.5f} mm ± {1e3 * found.sigma_pixel:.5f} mm on the floor below the camera',
    ]
    if options.calibration is None:
        focal = fit.camera.fx
        lines.append(f'focal length {focal:.1f} px ± {focal * found.sigma_focal:.1f} px, without distortion')
    if options.robot_at is None:
        lines.append('x, y and yaw of the camera are kept as given: not observable in one image')
    else:
        lines.append(f'x {1e3 * xyz[0]:.2f} mm, y {1e3 * xyz[1]:.2f} mm for the given pose of the robot')
    return lines


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    parser = argparse.ArgumentParser(
        prog='calibrate_camera',
        description='Calibrate height, tilt and pixel scale of the belly camera from an image of a printed mat.',
    )
    add = parser.add_argument
    add('--mat', type=Path, required=True, help='dot map that print_mat wrote')
    add('--image', type=Path, required=True, help='image of the mat, with the robot on a level floor')
    add('--calibration', type=Path, metavar='YAML',
        help='file written by camera_calibration; without it the focal length is found from --height')  # fmt: skip
    add('--height', type=float, metavar='M', help='height of the lens over the mat, measured with a ruler to 2 mm [m]')
    add('--robot-at', type=float, nargs=3, metavar=('X', 'Y', 'YAW'),
        help="the robot's pose on the mat [m, m, rad], to find x, y and yaw of the camera")  # fmt: skip
    add_mount_options(
        parser,
        'initial position of the camera; x and y are kept without --robot-at [m]',
        'initial roll, pitch, yaw of the camera [rad] (default: looking down)',
    )
    add('--out', type=Path, default=Path('belly_camera.yaml'), metavar='YAML', help='default: %(default)s')
    return parser


if __name__ == '__main__':
    sys.exit(main())
