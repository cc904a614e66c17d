"""Beacons as RViz markers."""

from __future__ import annotations

from collections.abc import Iterable

from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from vlc_beacon.core.pose.beacon import Beacon
from vlc_beacon.core.receiver.beacon_receiver import ReceiverOutput

_SEEN = ColorRGBA(r=0.1, g=0.8, b=0.2, a=1.0)
_SUSPECT = ColorRGBA(r=0.9, g=0.1, b=0.1, a=1.0)
_UNSEEN = ColorRGBA(r=0.5, g=0.5, b=0.5, a=1.0)
_TEXT = ColorRGBA(r=1.0, g=1.0, b=1.0, a=1.0)
_TEXT_HEIGHT = 0.15
"""[m]"""


def beacon_markers(beacons: Iterable[Beacon], output: ReceiverOutput, header: Header) -> MarkerArray:
    """Return markers of the beacons with their IDs: visible ones green, anomalous ones red, the others grey.

    Args:
        beacons: beacons of the file.
        output: receiver output of the image.
        header: stamp of the image and map frame.
    """
    seen = {lamp.beacon for lamp in output.lamps}
    suspect = {anomaly.id for anomaly in output.result.anomalies}
    markers = []
    for beacon in beacons:
        colour = _SUSPECT if beacon.id in suspect else _SEEN if beacon.id in seen else _UNSEEN
        markers.append(_marker(beacon, header, 'lamps', Marker.SPHERE, colour, 2.0 * beacon.radius))
        name = _marker(beacon, header, 'ids', Marker.TEXT_VIEW_FACING, _TEXT, _TEXT_HEIGHT)
        name.text = str(beacon.id)
        name.pose.position.z += beacon.radius + _TEXT_HEIGHT
        markers.append(name)
    return MarkerArray(markers=markers)


def _marker(
    beacon: Beacon, header: Header, namespace: str, kind: int, colour: ColorRGBA, size: float
) -> Marker:
    marker = Marker(header=header, ns=namespace, id=beacon.id, type=kind, action=Marker.ADD, color=colour)
    marker.pose.orientation.w = 1.0
    marker.pose.position.x, marker.pose.position.y, marker.pose.position.z = beacon.xyz
    marker.scale.x = marker.scale.y = marker.scale.z = size
    return marker
