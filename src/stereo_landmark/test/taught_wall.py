"""A rendered wall that was taught with small cameras, later views of it, and the files of both."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np
from drawn_wall import Disc, Plate, Wall, detect_view, from_left, look, teach_view
from place_scenes import MOUNT
from stereo_calibrations import rectified_calibration, write_calibration

from shirube_core.geometry import SE2, PinholeCamera, matrix_from_rpy
from stereo_landmark.core.pair.camera_pair import CameraCalibration, stereo_rig
from stereo_landmark.core.stereo import StereoImages
from stereo_landmark.files.place_file import save_place

SIDES = ('left', 'right')
CAMERA = PinholeCamera(376, 240, 350.0, 350.0, 187.5, 119.5)
CALIBRATIONS = rectified_calibration(CAMERA), rectified_calibration(CAMERA, 0.2)
RIG = stereo_rig(*CALIBRATIONS, MOUNT)
LENS = (-0.25, 0.06, 0.0005, -0.0008, 0.0)
TURNS = (-0.02, 0.01, 0.012), (0.02, -0.01, -0.015)
"""Rotations of the raw cameras relative to the rectified ones, roll, pitch, yaw [rad]."""
RAW = tuple(
    CameraCalibration(
        PinholeCamera(376, 240, 330.0, 331.0, 190.0 - shift, 118.0 + shift, LENS),
        tuple(matrix_from_rpy(turn).ravel().tolist()),
        rectified.projection,
    )
    for turn, rectified, shift in zip(TURNS, CALIBRATIONS, (0.0, 5.0))
)
"""Raw cameras whose rectification gives CALIBRATIONS."""
METERS = tuple(Disc(y, z, 0.1, 50.0) for y, z in ((0.7, 0.8), (0.2, 0.9), (-0.3, 0.75), (-0.8, 0.85)))
T_MAP_PLACE = SE2(10.0, -4.0, 2.0)
TAUGHT = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
HERE = (0.15, -0.1, 0.0, 0.06, 0.0, 0.0)
"""Pose of the repeat view: x, y, z [m], yaw, roll, pitch [rad] in the place frame."""
LEANING = (0.15, -0.1, 0.05, 0.06, 0.04, -0.03)
"""Pose of a tilted and raised robot."""


def clutter(count=30):
    """Return small, different plates around the meters."""
    rng = np.random.default_rng(7)
    plates = []
    while len(plates) < count:
        y, z = rng.uniform(-1.5, 1.5), rng.uniform(-0.2, 1.5)
        if min(np.hypot(meter.y - y, meter.z - z) for meter in METERS) > 0.3:
            plates.append(Plate(y, z, *rng.uniform(0.04, 0.25, 2), rng.choice([20.0, 90.0, 210.0, 245.0])))
    return tuple(plates)


WALL = Wall((*clutter(), *METERS))


@lru_cache
def seen(state):
    """Return the rectified pair from a robot state."""
    return tuple(look(WALL, np.array(state), RIG))


@lru_cache
def taught_place(name='wall'):
    """Return the place with the four meters as one target."""
    view = detect_view(seen(TAUGHT), RIG)
    meters = [each for each in from_left(view) if each.semi_axes[1] > 10.0]
    parts = {f'meter {i + 1}': meters[i] for i in range(len(METERS))}
    return teach_view(view, parts, name, T_MAP_PLACE, 'meters')


def raw_image(image, calibration):
    """Return the raw image of a camera of RAW from its rectified image, shape (h, w)."""
    raw, rectified = calibration.raw, calibration.rectified
    u, v = np.meshgrid(np.arange(raw.width, dtype=float), np.arange(raw.height, dtype=float))
    rays = raw.rays_from_pixels(np.column_stack([u.ravel(), v.ravel()]))
    seen_at = rectified.pixels_from_points(rays @ np.array(calibration.rotation).reshape(3, 3).T)
    maps = [each.reshape(u.shape).astype(np.float32) for each in seen_at.T]
    return cv2.remap(image, *maps, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)


def raw_pair(state):
    """Return the raw images from a robot state."""
    return [raw_image(image, calibration) for image, calibration in zip(seen(state), RAW)]


@dataclass
class Files:
    """Paths of the written files."""

    places: Path
    images: dict[str, Path]
    calibrations: dict[str, Path]

    def options(self, *more):
        """Return the options of ``locate`` for the pair."""
        options = ['--places', str(self.places), '--camera-xyz', *map(str, MOUNT.xyz)]
        for side in SIDES:
            options += [f'--{side}', str(self.images[side])]
            options += [f'--{side}-calibration', str(self.calibrations[side])]
        return [*options, *more]

    def write(self, images=None, calibrations=None):
        """Write other images or calibrations."""
        for side, image in zip(SIDES, images or ()):
            cv2.imwrite(str(self.images[side]), image)
        for side, calibration in zip(SIDES, calibrations or ()):
            write_calibration(self.calibrations[side], calibration)

    def truncate(self, side):
        """Cut an image file in half."""
        data = self.images[side].read_bytes()
        self.images[side].write_bytes(data[: len(data) // 2])

    def write_raw(self, state):
        """Write the raw images from a robot state and their calibrations."""
        self.write(raw_pair(state), RAW)


def write_pair(folder, state=HERE):
    """Write a pair and the calibrations."""
    images, calibrations = ({side: folder / f'{side}.{kind}' for side in SIDES} for kind in ('png', 'yaml'))
    files = Files(folder / 'places', images, calibrations)
    files.write(seen(state), CALIBRATIONS)
    return files


def write_files(folder):
    """Write the place, the pair at HERE and the calibrations."""
    files = write_pair(folder)
    save_place(files.places, taught_place(), StereoImages(*seen(TAUGHT)))
    return files
