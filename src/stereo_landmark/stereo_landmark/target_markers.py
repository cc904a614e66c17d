"""RViz markers of the detected targets."""

from __future__ import annotations

from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from stereo_landmark.core.pair.pair_localizer import LocatedPair
from stereo_landmark.core.place.place_locator import PlaceLocator
from stereo_landmark.core.place.stereo_points import is_measurable
from stereo_landmark.core.procedure.target_detection import TargetDetection

_POINTS = ColorRGBA(r=0.1, g=0.8, b=0.2, a=1.0)
_NAMES = ColorRGBA(r=1.0, g=1.0, b=1.0, a=1.0)
_DIAMETER, _TEXT_HEIGHT = 0.04, 0.12
"""Sizes of the markers [m]."""


def target_markers(located: LocatedPair, header: Header) -> MarkerArray:
    """Return markers with the measured points and name of each detected target; deletes the previous markers.

    Args:
        located: localization result of the pair.
        header: header with the stamp of the image and the base frame.
    """
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
