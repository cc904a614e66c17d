"""The receiver's output for people: beacons as RViz markers, and a debug image."""

from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.pose.pose_fix import BeaconFix
from vlc_beacon.core.receiver.beacon_receiver import ReceiverOutput

_SEEN = ColorRGBA(r=0.1, g=0.8, b=0.2, a=1.0)
_SUSPECT = ColorRGBA(r=0.9, g=0.1, b=0.1, a=1.0)
_UNSEEN = ColorRGBA(r=0.5, g=0.5, b=0.5, a=1.0)
_TEXT = ColorRGBA(r=1.0, g=1.0, b=1.0, a=1.0)
_TEXT_HEIGHT = 0.15
"""[m]"""


def beacon_markers(beacons: Iterable[Beacon], output: ReceiverOutput, header: Header) -> MarkerArray:
    """Return markers with IDs: visible beacons green, anomalous ones red, the others grey."""
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


def _marker(beacon: Beacon, header: Header, namespace: str, kind: int, colour: ColorRGBA, size: float) -> Marker:
    marker = Marker(header=header, ns=namespace, id=beacon.id, type=kind, action=Marker.ADD, color=colour)
    marker.pose.orientation.w = 1.0
    marker.pose.position.x, marker.pose.position.y, marker.pose.position.z = beacon.xyz
    marker.scale.x = marker.scale.y = marker.scale.z = size
    return marker


_IDENTIFIED, _UNKNOWN, _UNIDENTIFIED = (60, 220, 60), (40, 40, 230), (0, 200, 255)
_MARGIN = 3.0
"""Gap between a lamp and its circle [px]."""
_SUBPIXEL_BITS = 4
_FONT_SCALE = 0.5


def draw_debug_image(pixels: NDArray[np.uint8], output: ReceiverOutput) -> NDArray[np.uint8]:
    """Draw lamps with a known ID green, unknown ID red, no ID yellow, and the pose or the reason for none.

    Args:
        pixels: grey image, shape (h, w), or BGR image, shape (h, w, 3); not modified.
        output: receiver output of the image.

    Returns:
        BGR image, shape (h, w, 3).
    """
    coloured = cv2.cvtColor(pixels, cv2.COLOR_GRAY2BGR) if pixels.ndim == 2 else pixels
    canvas = np.array(coloured, dtype=np.uint8)
    unit = 1 << _SUBPIXEL_BITS
    for lamp in output.lamps:
        name = lamp.beacon if lamp.beacon is not None else lamp.unknown_id
        colour = _UNIDENTIFIED if name is None else _IDENTIFIED if lamp.beacon is not None else _UNKNOWN
        u, v = (float(position) for position in lamp.sample.centre)
        reach = lamp.sample.radius + _MARGIN
        centre = (round(u * unit), round(v * unit))
        cv2.circle(canvas, centre, round(reach * unit), colour, 1, cv2.LINE_AA, _SUBPIXEL_BITS)
        if name is not None:
            _put_text(canvas, str(name), (round(u + reach) + 2, round(v)), colour)
    _put_text(canvas, _headline(output), (4, 18), (255, 255, 255))
    return canvas


def _headline(output: ReceiverOutput) -> str:
    result = output.result
    if not isinstance(result, BeaconFix):
        return f'no fix: {result.reason.value}'
    pose = result.T_map_base
    return f'{pose.x:.3f} {pose.y:.3f} m {pose.yaw:.3f} rad'


def _put_text(canvas: NDArray[np.uint8], text: str, position: tuple[int, int], colour: tuple[int, int, int]) -> None:
    for shade, width in (((0, 0, 0), 3), (colour, 1)):
        cv2.putText(canvas, text, position, cv2.FONT_HERSHEY_SIMPLEX, _FONT_SCALE, shade, width, cv2.LINE_AA)
