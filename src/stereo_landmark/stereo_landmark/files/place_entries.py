"""Converts a taught place to and from the five sections of its file (paper 3.3)."""

import dataclasses
from typing import Any

import numpy as np

from shirube_core.geometry import SE2, CameraMount, PinholeCamera
from shirube_core.settings import SettingsError, describe_settings, settings_from_values
from stereo_landmark.core.primitives.corner import Corner
from stereo_landmark.core.primitives.ellipse import Ellipse
from stereo_landmark.core.primitives.parallel_lines import ParallelLines
from stereo_landmark.core.primitives.primitive import ImageProcessing, Primitive, PrimitiveKind, invariant_points
from stereo_landmark.core.primitives.quadrilateral import Quadrilateral
from stereo_landmark.core.procedure.taught_place import TaughtPlace, TaughtPrimitive, TaughtTarget
from stereo_landmark.core.stereo import INTRINSICS, SpatialPoints, StereoRig, calibration_hash
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

_REMEDY = 'restore the file or teach the place again'
_OBSOLETE_SETTINGS = frozenset({'edges.neighbour_distance'})
"""Obsolete settings of older files, which never had an effect."""
_LATER_SETTINGS = frozenset({'edges.thinning'})
"""Settings that older files do not have; their defaults are what these files were taught with."""


def place_entries(place: TaughtPlace) -> dict[str, Any]:
    """Return the file entries of a place: name, sections (a) to (e) and map pose."""
    pose, points = place.T_map_place, place.coordinates
    target_entries: list[dict[str, Any]] = [
        {'name': target.name, 'primitives': [primitive_entry(each) for each in target.primitives]}
        for target in place.targets
    ]
    for target, entry in zip(place.targets, target_entries, strict=True):
        if target.processing is not None:
            entry['image_processing'] = dataclasses.asdict(target.processing)
    return {
        'name': place.name,
        'stereo_calibration': calibration_entry(place.rig),
        'image_processing': dataclasses.asdict(place.processing),
        'targets': {
            'wanted': target_entries,
            'surroundings': [primitive_entry(each) for each in place.context_landmarks],
        },
        'corresponding_points': {target.name: target.points for target in place.targets},
        'coordinates': [
            {'point': name, 'xyz': position, 'covariance': covariance}
            for name, position, covariance in zip(points.names, points.positions, points.covariances, strict=True)
        ],
        'T_map_place': None if pose is None else {'x': pose.x, 'y': pose.y, 'yaw': pose.yaw},
    }


def place_from_entries(content: dict[str, Any]) -> TaughtPlace:
    """Return the place of entries that passed the schema check.

    Raises:
        StereoLandmarkError: sections are inconsistent, or a value is out of range; the message begins with the field.
    """
    point_names = content['corresponding_points']
    target_entries = content['targets']['wanted']
    _check_names('targets.wanted', [each['name'] for each in target_entries])
    targets = tuple(_target(each, point_names) for each in target_entries)
    for name in point_names:
        if name not in [target.name for target in targets]:
            raise StereoLandmarkError(f'corresponding_points.{name}: there is no such target; {_REMEDY}')
    coordinates = _coordinates(content['coordinates'])
    _check_points(targets, coordinates)
    pose = content['T_map_place']
    return TaughtPlace(
        content['name'],
        rig_from_entry(content['stereo_calibration']),
        targets,
        coordinates,
        tuple(primitive_from_entry(each) for each in content['targets']['surroundings']),
        processing_from_entry(content['image_processing']),
        None if pose is None else SE2(float(pose['x']), float(pose['y']), float(pose['yaw'])),
    )


def processing_from_entry(entry: dict[str, Any]) -> ImageProcessing:
    """Return the image processing; every setting must be present.

    Raises:
        StereoLandmarkError: a setting is missing, unknown or out of range.
    """
    values = {name: value for name, value in flatten(entry).items() if name not in _OBSOLETE_SETTINGS}
    for setting in describe_settings(ImageProcessing):
        if setting.name not in values and setting.name not in _LATER_SETTINGS:
            raise StereoLandmarkError(f'image_processing.{setting.name} is missing; {_REMEDY}')
    try:
        return settings_from_values(ImageProcessing, values)
    except SettingsError as fault:
        raise StereoLandmarkError(f'image_processing: {fault}') from fault


def _target(entry: dict[str, Any], point_names: dict[str, list[str]]) -> TaughtTarget:
    name = entry['name']
    _check_names(f'targets.wanted {name}', [each['name'] for each in entry['primitives']])
    if name not in point_names:
        raise StereoLandmarkError(f'corresponding_points.{name} is missing; {_REMEDY}')
    primitives = tuple(primitive_from_entry(each) for each in entry['primitives'])
    own = entry.get('image_processing')
    processing = None if own is None else processing_from_entry(own)
    return TaughtTarget(name, primitives, tuple(point_names[name]), processing)


def _coordinates(entries: list[dict[str, Any]]) -> SpatialPoints:
    names = [entry['point'] for entry in entries]
    _check_names('coordinates', names)
    positions = np.array([entry['xyz'] for entry in entries], dtype=np.float64)
    covariances = np.array([entry['covariance'] for entry in entries], dtype=np.float64)
    for name, covariance in zip(names, covariances, strict=True):
        slack = 1e-9 * abs(float(np.trace(covariance)))
        is_symmetric = np.allclose(covariance, covariance.T, rtol=0.0, atol=slack)
        if not is_symmetric or np.linalg.eigvalsh(covariance)[0] < -slack:
            raise StereoLandmarkError(f'coordinates {name}: covariance is not positive semidefinite; {_REMEDY}')
    return SpatialPoints(tuple(names), positions, covariances)


def _check_points(targets: tuple[TaughtTarget, ...], coordinates: SpatialPoints) -> None:
    """Reject places with points that have no coordinates."""
    for target in targets:
        for primitive in target.primitives:
            for point in invariant_points(primitive.shape):
                name = f'{target.name}/{primitive.name}/{point}'
                if name not in coordinates.names:
                    raise StereoLandmarkError(f'coordinates: {name} is missing; {_REMEDY}')
        for point in target.points:
            if f'{target.name}/{point}' not in coordinates.names:
                raise StereoLandmarkError(f'corresponding_points.{target.name}: {point} has no coordinates; {_REMEDY}')


def _check_names(field: str, names: list[str]) -> None:
    for name in names:
        if names.count(name) > 1:
            raise StereoLandmarkError(f'{field}: {name} is duplicate; {_REMEDY}')


def calibration_entry(rig: StereoRig) -> dict[str, Any]:
    """Return the file entry of the stereo calibration."""
    left, right = (
        {name: value for name, value in dataclasses.asdict(camera).items() if name in INTRINSICS}
        for camera in (rig.left, rig.right)
    )
    return {
        'hash': calibration_hash(rig),
        'left': left,
        'right': right,
        'baseline': rig.baseline,
        'camera_xyz': rig.mount.xyz,
        'camera_rpy': rig.mount.rpy,
    }


def rig_from_entry(entry: dict[str, Any]) -> StereoRig:
    """Return the stereo calibration of an entry that passed the schema check.

    Raises:
        StereoLandmarkError: the cameras are not a stereo pair, or do not match the hash.
    """
    left, right = (_camera(entry[side]) for side in ('left', 'right'))
    (x, y, z), (roll, pitch, yaw) = (map(float, entry[name]) for name in ('camera_xyz', 'camera_rpy'))
    mount = CameraMount((x, y, z), (roll, pitch, yaw))
    try:
        rig = StereoRig(left, right, float(entry['baseline']), mount)
    except StereoLandmarkError as fault:
        raise StereoLandmarkError(f'stereo_calibration: {fault}') from fault
    if calibration_hash(rig) != entry['hash']:
        raise StereoLandmarkError(f'stereo_calibration: hash does not match the calibration; {_REMEDY}')
    return rig


def _camera(entry: dict[str, Any]) -> PinholeCamera:
    fx, fy, cx, cy = (float(entry[name]) for name in INTRINSICS[2:])
    return PinholeCamera(entry['width'], entry['height'], fx, fy, cx, cy)


_TYPES: dict[PrimitiveKind, tuple[type[Primitive], int]] = {
    PrimitiveKind.ELLIPSE: (Ellipse, 5),
    PrimitiveKind.QUADRILATERAL: (Quadrilateral, 8),
    PrimitiveKind.PARALLEL_LINES: (ParallelLines, 3),
    PrimitiveKind.CORNER: (Corner, 2),
}
"""Class of each kind and size of its covariance matrix, which is not stored."""


def primitive_entry(taught: TaughtPrimitive) -> dict[str, Any]:
    """Return the file entry of a primitive."""
    names = [field.name for field in dataclasses.fields(taught.shape) if field.name != 'covariance']
    shape = {name: getattr(taught.shape, name) for name in names}
    entry = {'name': taught.name, 'kind': taught.kind.value, 'position': taught.position, 'shape': shape}
    return entry if taught.normal is None else {**entry, 'normal': taught.normal}


def primitive_from_entry(entry: dict[str, Any]) -> TaughtPrimitive:
    """Return the primitive of an entry that passed the schema check."""
    kind, rows = _TYPES[PrimitiveKind(entry['kind'])]
    values = {name: _number_or_array(name, value) for name, value in entry['shape'].items()}
    shape = kind(**values, covariance=np.zeros((rows, rows)))
    normal = np.array(entry['normal'], dtype=np.float64) if 'normal' in entry else None
    return TaughtPrimitive(entry['name'], shape, np.array(entry['position'], dtype=np.float64), normal)


def _number_or_array(name: str, value: Any) -> Any:
    if isinstance(value, list):
        return np.array(value, dtype=np.float64)
    return value if name == 'polarity' else float(value)


def flatten(entry: dict[str, Any], prefix: str = '') -> dict[str, object]:
    """Return the values of nested entries by their full names, ``group.name``."""
    values: dict[str, object] = {}
    for name, value in entry.items():
        if isinstance(value, dict):
            values |= flatten(value, f'{prefix}{name}.')
        else:
            values[f'{prefix}{name}'] = value
    return values
