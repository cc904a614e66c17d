"""What the node publishes about a pair: displacement, markers, debug image and diagnostics."""

from collections import Counter
from collections.abc import Callable
from time import monotonic

import cv2
import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Quaternion, Transform, TransformStamped, Vector3
from numpy.typing import NDArray
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from shirube_core.geometry import quaternion_from_yaw
from shirube_ros.diagnostics import Level, Status
from stereo_landmark.core.landmark_localizer import LandmarkFix, NoLandmarkFix
from stereo_landmark.core.pair.pair_stream import LocatedPair
from stereo_landmark.core.place.place_locator import PlaceLocator
from stereo_landmark.core.procedure.target_search import TargetDetection
from stereo_landmark.core.stereo import is_measurable


def displacement_message(fix: LandmarkFix, stamp: Time, base_frame: str) -> TransformStamped:
    """Return the pose of the gravity-aligned base in the place frame, whose frame ID is the name of the place."""
    pose = fix.displacement.T_place_base
    x, y, z, w = quaternion_from_yaw(pose.yaw)
    return TransformStamped(
        header=Header(stamp=stamp, frame_id=fix.place.name),
        child_frame_id=base_frame,
        transform=Transform(
            translation=Vector3(x=pose.x, y=pose.y, z=fix.displacement.height), rotation=Quaternion(x=x, y=y, z=z, w=w)
        ),
    )


_POINTS = ColorRGBA(r=0.1, g=0.8, b=0.2, a=1.0)
_NAMES = ColorRGBA(r=1.0, g=1.0, b=1.0, a=1.0)
_DIAMETER, _TEXT_HEIGHT = 0.04, 0.12
"""Sizes of the markers [m]."""


def target_markers(located: LocatedPair, header: Header) -> MarkerArray:
    """Return markers with the measured points and name of each detected target; deletes the previous markers."""
    markers = [Marker(header=header, action=Marker.DELETEALL)]
    locator = PlaceLocator(located.rig)
    for number, detection in enumerate(located.result.detections):
        if not isinstance(detection, TargetDetection):
            continue
        seen = detection.points.subset(is_measurable(detection.points, located.rig))
        if not len(seen):
            continue
        # The base frame tilts with the robot, so no tilt compensation.
        positions = locator.spatial_points(seen).positions
        points = _marker(header, 'points', number, Marker.SPHERE_LIST, _POINTS, _DIAMETER)
        points.points = [Point(x=x, y=y, z=z) for x, y, z in positions.tolist()]
        name = _marker(header, 'names', number, Marker.TEXT_VIEW_FACING, _NAMES, _TEXT_HEIGHT)
        name.text = detection.target
        x, y, z = positions.mean(axis=0).tolist()
        name.pose.position = Point(x=x, y=y, z=z + 2.0 * _TEXT_HEIGHT)
        markers += [points, name]
    return MarkerArray(markers=markers)


def _marker(header: Header, namespace: str, number: int, kind: int, colour: ColorRGBA, size: float) -> Marker:
    marker = Marker(header=header, ns=namespace, id=number, type=kind, action=Marker.ADD, color=colour)
    marker.pose.orientation.w = 1.0
    marker.scale.x = marker.scale.y = marker.scale.z = size
    return marker


_USED, _UNUSED, _TEXT_COLOUR = (60, 220, 60), (0, 200, 255), (255, 255, 255)
_SUBPIXEL_BITS = 4
_CROSS_ARM = 6.0
"""Arm length of the cross on a point [px]."""
_TEXT_SCALE = 0.45


def debug_picture(located: LocatedPair) -> NDArray[np.uint8]:
    """Draw the points used for the pose (green), the other detected points (yellow) and the pose or failure reason.

    Returns:
        BGR image, shape (h, w, 3).
    """
    picture = np.array(cv2.cvtColor(located.left, cv2.COLOR_GRAY2BGR), dtype=np.uint8)
    result = located.result
    used = result.displacement.names if isinstance(result, LandmarkFix) else ()
    for detection in result.detections:
        if not isinstance(detection, TargetDetection):
            continue
        for name, pixels in zip(detection.points.names, detection.points.pixels, strict=True):
            colour = _USED if name in used else _UNUSED
            _draw_cross(picture, pixels[:2], colour)
        if len(detection.points):
            u, v = np.rint(detection.points.pixels[0, :2]).astype(int)
            _draw_text(picture, detection.target, (int(u) + 8, int(v) - 8), _USED)
    _draw_text(picture, _headline(result), (4, 16), _TEXT_COLOUR)
    return picture


def _headline(result: LandmarkFix | NoLandmarkFix) -> str:
    if isinstance(result, NoLandmarkFix):
        return f'no fix: {result.reason}'
    pose = result.displacement.T_place_base
    return f'{result.place.name}: {pose.x:.3f} {pose.y:.3f} m {pose.yaw:.3f} rad'


def _draw_cross(picture: NDArray[np.uint8], place: NDArray[np.float64], colour: tuple[int, int, int]) -> None:
    for step in (np.array([_CROSS_ARM, 0.0]), np.array([0.0, _CROSS_ARM])):
        begin, end = (np.rint((place + shift) * (1 << _SUBPIXEL_BITS)).astype(int) for shift in (-step, step))
        cv2.line(picture, begin.tolist(), end.tolist(), colour, 1, cv2.LINE_AA, _SUBPIXEL_BITS)


def _draw_text(picture: NDArray[np.uint8], text: str, place: tuple[int, int], colour: tuple[int, int, int]) -> None:
    for shade, width in (((0, 0, 0), 3), (colour, 1)):
        cv2.putText(picture, text, place, cv2.FONT_HERSHEY_SIMPLEX, _TEXT_SCALE, shade, width, cv2.LINE_AA)


_PAIR_TIMEOUT = 2.0
"""A pose is stale when no image pair was received for this time [s]."""


class LocalizerReport:
    """Keeps the latest result and counts the results by place and failure reason."""

    def __init__(self, places_dir: str, now: Callable[[], float] = monotonic) -> None:
        self._places_dir = places_dir
        self._now = now
        self._latest: LocatedPair | None = None
        self._latest_at = -float('inf')
        self._duration = 0.0
        self._fixes: Counter[str] = Counter()
        self._no_fixes: Counter[str] = Counter()

    def add(self, located: LocatedPair, duration: float) -> None:
        """Add the result of a pair and its processing time [s]."""
        self._latest, self._latest_at, self._duration = located, self._now(), duration
        if isinstance(located.result, LandmarkFix):
            self._fixes[located.result.place.name] += 1
        else:
            self._no_fixes[located.result.reason] += 1

    def status(self) -> Status:
        """Return the present diagnostic status."""
        values = {'places': self._places_dir}
        values |= {f'pairs at {name}': str(number) for name, number in self._fixes.items()}
        values |= {f'pairs without: {reason}': str(number) for reason, number in self._no_fixes.items()}
        if self._latest is None:
            return Status(Level.WARN, 'no image pair received; check both images and camera_info', values)
        result = self._latest.result
        values |= {'processing time [ms]': f'{1e3 * self._duration:.1f}'}
        if self._latest.is_tilt_missing:
            values |= {'tilt': 'assumed level'}
        if self._now() - self._latest_at > _PAIR_TIMEOUT:
            return Status(Level.WARN, 'image pairs timed out; check the cameras', values)
        if not isinstance(result, LandmarkFix):
            return Status(Level.WARN, f'no fix: {result.reason}', values | {'detail': result.detail})
        if self._latest.is_tilt_missing:
            why = 'assumed level: no IMU reading near the stamp of the images; check the stamps of both'
            return Status(Level.WARN, f'at {result.place.name}, {why}', values | _fix_values(result))
        return Status(Level.OK, f'at {result.place.name}', values | _fix_values(result))


def _fix_values(fix: LandmarkFix) -> dict[str, str]:
    displacement = fix.displacement
    pose, sigmas = displacement.T_place_base, displacement.covariance.diagonal() ** 0.5
    found = [each.target for each in fix.detections if isinstance(each, TargetDetection)]
    return {
        'targets found': ', '.join(found),
        'measured by patches': ', '.join(fix.matched_patches) or 'none; measured by outlines',
        'points used': str(len(displacement.names)),
        'x, y, yaw': f'{pose.x:.4f} m, {pose.y:.4f} m, {pose.yaw:.4f} rad',
        'sigma x, y, yaw': f'{sigmas[0]:.4f} m, {sigmas[1]:.4f} m, {sigmas[3]:.4f} rad',
        'height of base_frame': f'{displacement.height:.4f} m',
    }
