"""Stereo pairs of image files for the page."""

from __future__ import annotations

import argparse

from shirube_core.geometry import CameraMount
from shirube_ros.camera.files import list_images
from stereo_landmark.core.pair.camera_calibration import stereo_rig
from stereo_landmark.core.pair.stereo_images import StereoImages
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.files.calibration_file import load_camera_calibration
from stereo_landmark.files.grey_image import load_grey_image
from stereo_landmark.page.pair_source import RecordedPairs


def file_pairs(options: argparse.Namespace, mount: CameraMount) -> RecordedPairs:
    """Return the stereo pairs of the image files in the options.

    Raises:
        StereoLandmarkError: files are missing, or the calibrations are not those of a stereo pair.
        CameraFileError: a file is malformed.
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
    roll, pitch = options.tilt

    def read(number: int) -> StereoImages:
        return StereoImages(load_grey_image(left[number]), load_grey_image(right[number]), (roll, pitch))

    raw = calibrations if options.rectify else None
    return RecordedPairs([path.name for path in left], read, stereo_rig(*calibrations, mount), raw)
