"""Loads a lesson of ``teach --batch``: the selections otherwise made on the teaching page, and its stereo pair."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shirube_bags.bag_reader import BagReader
from shirube_core.geometry import SE2, CameraMount
from shirube_core.settings import SettingsError, settings_from_values
from shirube_ros.camera.image import to_grey
from stereo_landmark.core.pair.camera_pair import CameraCalibration, Rectifier, check_size, stereo_rig
from stereo_landmark.core.pair.rectification_check import PairCheck, check_pair
from stereo_landmark.core.primitives.primitive import ImageProcessing, PrimitiveKind
from stereo_landmark.core.stereo import StereoImages, StereoRig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.primitive_selection import (
    ANY_SIZE,
    NearestSelection,
    RegionSelection,
    Selection,
    SortOrder,
)
from stereo_landmark.files.camera_files import choose_topics, load_camera_calibration, load_grey_image, recorded_pairs
from stereo_landmark.files.place_entries import flatten
from stereo_landmark.files.yaml_file import LandmarkFileError, check_schema, read_yaml

_REMEDY = 'correct it'


CameraImage = tuple[NDArray[np.uint8], CameraCalibration]
"""Grey image, shape (h, w), and the calibration of its camera."""
LoadedPair = tuple[CameraImage, CameraImage, tuple[float, float] | None]
"""Left and right image, and the tilt that the IMU measured near them [rad]."""


@dataclass(frozen=True)
class TargetConfig:
    """Configuration of one target.

    Attributes:
        name: name of the target.
        selections: selections of its primitives, the most reliable first.
        points: names ``primitive/point`` of the points used for the pose; None for all.
        processing: image processing of its own; None for that of the place.
    """

    name: str
    selections: list[Selection]
    points: tuple[str, ...] | None
    processing: ImageProcessing | None = None


@dataclass(frozen=True)
class TeachConfig:
    """Configuration for teaching a place in batch mode.

    Attributes:
        name: name of the place.
        load: loads the stereo pair, raw or rectified.
        mount: extrinsics of the left camera's rectified optical frame.
        targets: configurations of the targets.
        is_raw: whether the images have to be rectified.
        tilt: roll and pitch of the robot [rad]; None to use the imu of the bag, or zero without one.
        T_map_place: pose of the place in the map, None if unknown.
        processing: image processing.
    """

    name: str
    load: Callable[[], LoadedPair]
    mount: CameraMount
    targets: list[TargetConfig]
    is_raw: bool = False
    tilt: tuple[float, float] | None = None
    T_map_place: SE2 | None = None
    processing: ImageProcessing = field(default_factory=ImageProcessing)


def load_teach_config(path: Path) -> TeachConfig:
    """Load a teach config.

    Raises:
        LandmarkFileError: the file is malformed; the message names file, field and remedy.
    """
    content = read_yaml(path, _REMEDY)
    check_schema(content, 'teach_config_schema', str(path), _REMEDY)
    if ('bag' in content) == ('images' in content) or ('bag' in content) == ('calibration' in content):
        raise LandmarkFileError(f'{path}: give either images and calibration, or bag')
    processing = _processing(f'{path}: image_processing', content)
    x, y, z = map(float, content['camera_xyz'])
    roll, pitch, yaw = map(float, content['camera_rpy'])
    tilt, pose = content.get('tilt'), content.get('T_map_place')
    return TeachConfig(
        content['name'],
        _source(path.parent, content),
        CameraMount((x, y, z), (roll, pitch, yaw)),
        [_target(path, entry, content) for entry in content['targets']],
        content.get('rectify', False),
        None if tilt is None else (float(tilt[0]), float(tilt[1])),
        None if pose is None else SE2(float(pose['x']), float(pose['y']), float(pose['yaw'])),
        processing,
    )


def _source(folder: Path, content: dict[str, Any]) -> Callable[[], LoadedPair]:
    if 'images' in content:
        files = ([folder / content[name][side] for side in ('left', 'right')] for name in ('images', 'calibration'))
        return partial(_load_from_files, *files)
    bag = dict(content['bag'])
    tolerance = float(content.get('approximate_sync_tolerance_seconds', 0.0))
    path, stamp = folder / bag.pop('path'), bag.pop('stamp', None)
    return partial(_load_from_bag, path, stamp, tolerance, bag, is_raw=content.get('rectify', False))


def _processing(where: str, *contents: dict[str, Any]) -> ImageProcessing:
    """Return the image processing of entries, the later ones of which override the earlier ones."""
    values = {name: value for each in contents for name, value in flatten(each.get('image_processing', {})).items()}
    try:
        return settings_from_values(ImageProcessing, values)
    except SettingsError as fault:
        raise LandmarkFileError(f'{where}: {fault}') from fault


def _target(path: Path, entry: dict[str, Any], content: dict[str, Any]) -> TargetConfig:
    where = f'{path}: target {entry["name"]}'
    selections = [_selection(where, selection) for selection in entry['primitives']]
    own = 'image_processing' in entry
    processing = _processing(f'{where}: image_processing', content, entry) if own else None
    points = tuple(entry['points']) if 'points' in entry else None
    return TargetConfig(entry['name'], selections, points, processing)


def _selection(where: str, entry: dict[str, Any]) -> Selection:
    kind, name = PrimitiveKind(entry['kind']), entry.get('name', '')
    if ('near' in entry) == ('region' in entry):
        raise LandmarkFileError(f'{where}: give each primitive either near or region')
    smallest, largest = map(float, entry.get('size', ANY_SIZE))
    if 'near' in entry:
        for other in ('order', 'count'):
            if other in entry:
                raise LandmarkFileError(f'{where}: {other} is only valid with region; remove it')
        u, v = map(float, entry['near'])
        return NearestSelection(kind, (u, v), (smallest, largest), name)
    left, top, right, bottom = map(float, entry['region'])
    order = SortOrder(entry.get('order', SortOrder.LEFT_TO_RIGHT.value))
    region = (left, top, right, bottom)
    return RegionSelection(kind, region, (smallest, largest), order, entry.get('count'), name)


def load_pair(config: TeachConfig) -> tuple[StereoImages, StereoRig, PairCheck]:
    """Load the pair of a config, rectified, its cameras, and how well it is rectified.

    Raises:
        StereoLandmarkError: the calibrations are not a stereo pair, or do not match the images.
        CameraFileError: an image or calibration file is missing, truncated or malformed.
        BagError: the bag cannot be read.
    """
    left, right, tilt = config.load()
    rig = stereo_rig(left[1], right[1], config.mount)
    images = []
    for image, calibration in (left, right):
        check_size(image, calibration)
        images.append(Rectifier(calibration).rectify(image) if config.is_raw else image)
    check = check_pair(images[0], images[1], rig)
    if check.fault is not None:
        raise StereoLandmarkError(check.summary)
    return StereoImages(images[0], images[1], config.tilt or tilt or (0.0, 0.0)), rig, check


def _load_from_files(images: Sequence[Path], calibrations: Sequence[Path]) -> LoadedPair:
    left, right = (
        (load_grey_image(image), load_camera_calibration(calibration))
        for image, calibration in zip(images, calibrations, strict=True)
    )
    return left, right, None


def _load_from_bag(
    path: Path, stamp: float | None, tolerance: float, names: dict[str, str], *, is_raw: bool
) -> LoadedPair:
    """Return the first pair from the stamp [s] on, of all without one, whose stamps differ by the tolerance [s]."""
    with BagReader(path) as bag:
        topics = choose_topics(bag, names, is_raw=is_raw)
        pair = next(recorded_pairs(bag, topics, tolerance, None if stamp is None else round(stamp * 1e9)), None)
    if pair is not None:
        left, right = pair.left, pair.right
        return (to_grey(left.pixels), left.calibration), (to_grey(right.pixels), right.calibration), pair.tilt
    when = '' if stamp is None else f' at or after {stamp:.9g} s'
    raise StereoLandmarkError(
        f'{path}: no pair of valid images with matching stamps{when}; '
        'correct stamp, or set approximate_sync_tolerance_seconds'
    )
