"""Loads the rectified stereo pair of a teach configuration from image files or a bag."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shirube_bags.bag_reader import BagReader
from stereo_landmark.core.pair.camera_calibration import CameraCalibration, stereo_rig
from stereo_landmark.core.pair.epipolar_check import pair_fault
from stereo_landmark.core.pair.rectification import Rectifier
from stereo_landmark.core.pair.stereo_images import StereoImages
from stereo_landmark.core.place.stereo_rig import StereoRig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.files.calibration_file import load_camera_calibration
from stereo_landmark.files.grey_image import load_grey_image, to_grey
from stereo_landmark.files.teach_config_file import BagStamp, CalibratedImages, TeachConfig
from stereo_landmark.pair_recording import choose_topics
from stereo_landmark.recorded_pairs import recorded_pairs

CameraImage = tuple[NDArray[np.uint8], CameraCalibration]
"""Grey image, shape (h, w), and the calibration of its camera."""


@dataclass(frozen=True)
class RectifiedPair:
    """A rectified stereo pair and its cameras.

    Attributes:
        images: rectified images with the tilt of the base.
        rig: rectified cameras.
    """

    images: StereoImages
    rig: StereoRig


def load_pair(config: TeachConfig) -> RectifiedPair:
    """Load the pair and rectify it if it is raw.

    Raises:
        StereoLandmarkError: the calibrations are not a stereo pair, or do not match the images.
        CameraFileError: an image or calibration file is missing, truncated or malformed.
        BagError: the bag cannot be read.
    """
    if isinstance(config.source, BagStamp):
        left, right, tilt = _load_from_bag(config.source, is_raw=config.is_raw)
    else:
        (left, right), tilt = _load_from_files(config.source), None
    rig = stereo_rig(left[1], right[1], config.mount)
    images = []
    for image, calibration in (left, right):
        if image.shape != (calibration.height, calibration.width):
            raise StereoLandmarkError(
                f'an image is {image.shape[1]} x {image.shape[0]} px, its calibration is for '
                f'{calibration.width} x {calibration.height} px; calibrate at the resolution in use'
            )
        images.append(Rectifier(calibration).rectify(image) if config.is_raw else image)
    fault = pair_fault(images[0], images[1], rig)
    if fault is not None:
        raise StereoLandmarkError(fault.value)
    return RectifiedPair(StereoImages(images[0], images[1], config.tilt or tilt or (0.0, 0.0)), rig)


def _load_from_files(source: CalibratedImages) -> tuple[CameraImage, CameraImage]:
    left, right = (
        (load_grey_image(image), load_camera_calibration(calibration))
        for image, calibration in (
            (source.images.left, source.calibrations.left),
            (source.images.right, source.calibrations.right),
        )
    )
    return left, right


def _load_from_bag(
    moment: BagStamp, *, is_raw: bool
) -> tuple[CameraImage, CameraImage, tuple[float, float] | None]:
    """Return the first pair from the stamp on, and the tilt that the IMU measured near it."""
    begin = None if moment.stamp is None else round(moment.stamp * 1e9)
    with BagReader(moment.path) as bag:
        topics = choose_topics(bag, moment.topics, is_raw=is_raw)
        pair = next(recorded_pairs(bag, topics, moment.sync_tolerance, begin), None)
    if pair is not None:
        left, right = pair.left, pair.right
        return (to_grey(left.pixels), left.calibration), (to_grey(right.pixels), right.calibration), pair.tilt
    when = '' if moment.stamp is None else f' at or after {moment.stamp:.9g} s'
    raise StereoLandmarkError(
        f'{moment.path}: no pair of valid images with matching stamps{when}; '
        'correct stamp, or set approximate_sync_tolerance_seconds'
    )
