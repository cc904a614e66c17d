"""``calibrate``: blooming of a lamp from images at known distances."""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import yaml

from shirube_core.command import run_command
from shirube_core.files import write_text
from shirube_ros.camera.files import load_image
from shirube_ros.camera.image import to_grey
from shirube_ros.errors import CameraFileError
from vlc_beacon.core.lamp_image.blooming import BloomingCalibration, BloomingFit, calibrate_blooming, fit_blooming
from vlc_beacon.core.lamp_image.lamp_detector import LampDetector
from vlc_beacon.core.vlc_beacon_error import LampImageError, VlcBeaconError


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 when an image or an option is bad."""
    options = make_parser().parse_args(arguments)
    return run_command('calibrate', lambda: calibrate_and_save(options), (VlcBeaconError, CameraFileError))


def calibrate_and_save(options: argparse.Namespace) -> None:
    """Calibrate, and write and print the result."""
    blooming = calibrate(options)
    write_text(options.out, yaml.safe_dump({'blooming': asdict(blooming)}, sort_keys=False))
    print(f'{"beta":<16}{blooming.beta:.3f} +- {blooming.beta_sigma:.3f} px')
    print(f'{"alpha":<16}{blooming.alpha:.2f} /px')
    print(f'{"gamma":<16}{blooming.gamma:.1f} grey levels; see {options.out}')


def calibrate(options: argparse.Namespace) -> BloomingCalibration:
    """Fit the blooming model to the images and print the result of each image.

    Raises:
        VlcBeaconError: an image without a complete lamp, or without a distance.
        CameraFileError: a file is not an image.
    """
    fits, depths = [], []
    for text in options.image:
        name, _, metres = text.rpartition('=')
        depths.append(_parse_depth(text, metres))
        fits.append(_fit_brightest_lamp(Path(name)))
        true_radius = options.lamp_radius * options.focal_length / depths[-1]
        print(f'{name}: radius {fits[-1].half_maximum_radius:.2f} px, true radius {true_radius:.2f} px')
    return calibrate_blooming(fits, depths, options.lamp_radius, options.focal_length)


def _parse_depth(text: str, metres: str) -> float:
    try:
        depth = float(metres)
    except ValueError:
        depth = 0.0
    if not 0.0 < depth < float('inf'):
        raise VlcBeaconError(f'{text}: give each image as IMAGE=METRES, the distance along the optical axis')
    return depth


def _fit_brightest_lamp(path: Path) -> BloomingFit:
    image = to_grey(load_image(path))
    try:
        lamps = LampDetector().detect(image)
        if len(lamps) == 0:
            raise LampImageError('no lamp found; expose so that it is bright and round')
        return fit_blooming(image, lamps.centroids[0], float(lamps.radii[0]))
    except LampImageError as error:
        raise VlcBeaconError(f'{path}: {error}') from error


def make_parser() -> argparse.ArgumentParser:
    """Return the command-line parser."""
    parser = argparse.ArgumentParser(
        prog='calibrate',
        description='Calibrate the blooming of a lamp from images at known distances. The lamp must be on without '
        'blinking, with both halves, and be the brightest light; two or more distances give the standard deviation.',
    )
    add = parser.add_argument
    add('image', nargs='+', metavar='IMAGE=METRES', help='image and distance of the lamp along the optical axis')
    add('--focal-length', type=float, required=True, help='focal length of the camera [px], fx of its calibration')
    add('--lamp-radius', type=float, required=True, help='radius of the bright disc [m]')
    add('--out', type=Path, default=Path('out/blooming.yaml'), metavar='FILE', help='default: %(default)s')
    return parser


if __name__ == '__main__':
    sys.exit(main())
