"""What RViz shows of a result: markers at the dots on the map, and the camera image with the detected dots."""

import cv2
import numpy as np
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from floor_localizer.core.arrays import Booleans, Pixels
from floor_localizer.core.dots import DetectedDots
from floor_localizer.core.fix import Fix, NoFix
from shirube_core.geometry import CameraMount, PinholeCamera

_MATCHED_COLOUR = ColorRGBA(r=0.1, g=0.8, b=0.2, a=1.0)
_UNMATCHED_COLOUR = ColorRGBA(r=0.9, g=0.1, b=0.1, a=1.0)

_MATCHED = (60, 200, 30)  # blue, green, red
_UNMATCHED = (40, 40, 230)
_BACKGROUND = (0, 0, 0)
_SUBPIXEL_BITS = 4  # cv2.circle takes fixed-point coordinates
_MARGIN = 2.5  # gap between a dot and its ring [px]
_SMALL_WIDTH = 235  # image width for the text scale _SMALL_TEXT [px]
_SMALL_TEXT = 0.33


def dot_markers(fix: Fix, camera: PinholeCamera, mount: CameraMount, header: Header) -> MarkerArray:
    """Return markers at the image's dots on the map: matched ones green, the others red.

    The mount is the nominal one; the header has the stamp of the image and the map frame.
    """
    points_base = mount.floor_points_from_rays(camera.rays_from_pixels(fix.dots.pixels))
    points_map = fix.T_map_base.transform(points_base)
    metres_per_pixel = mount.xyz[2] / camera.fx
    diameter = float(np.median(fix.dots.diameters)) * metres_per_pixel
    groups = (('matched', _MATCHED_COLOUR, fix.matched), ('unmatched', _UNMATCHED_COLOUR, ~fix.matched))
    markers = []
    for namespace, colour, chosen in groups:
        marker = Marker(header=header, ns=namespace, type=Marker.SPHERE_LIST, action=Marker.ADD, color=colour)
        marker.pose.orientation.w = 1.0
        marker.scale.x = marker.scale.y = marker.scale.z = diameter
        marker.points = [Point(x=float(x), y=float(y)) for x, y in points_map[chosen]]
        markers.append(marker)
    return MarkerArray(markers=markers)


def delete_markers(header: Header) -> MarkerArray:
    """Return a marker message that deletes the dots of earlier images."""
    return MarkerArray(markers=[Marker(header=header, action=Marker.DELETEALL)])


def debug_picture(pixels: Pixels, result: Fix | NoFix) -> Pixels:
    """Return the image in BGR with matched dots green, unmatched ones red, and the pose or why there is none."""
    picture = np.array(cv2.cvtColor(pixels, cv2.COLOR_GRAY2BGR) if pixels.ndim == 2 else pixels, dtype=np.uint8)
    if isinstance(result, Fix):
        _draw_rings(picture, result.dots, result.matched)
        pose = result.T_map_base
        _write(picture, f'{pose.x:.4f} {pose.y:.4f} m {pose.yaw:.4f} rad')
    else:
        if result.dots is not None:
            _draw_rings(picture, result.dots, np.zeros(len(result.dots), dtype=np.bool_))
        _write(picture, f'no fix: {result.reason.name.lower().replace("_", " ")}')
    return picture


def _draw_rings(picture: Pixels, dots: DetectedDots, matched: Booleans) -> None:
    unit = 1 << _SUBPIXEL_BITS
    for (u, v), diameter, is_matched in zip(dots.pixels, dots.diameters, matched, strict=True):
        centre = (round(u * unit), round(v * unit))
        radius = round((diameter / 2.0 + _MARGIN) * unit)
        colour = _MATCHED if is_matched else _UNMATCHED
        cv2.circle(picture, centre, radius, colour, 1, cv2.LINE_AA, _SUBPIXEL_BITS)


def _write(picture: Pixels, text: str) -> None:
    scale = _SMALL_TEXT * max(1.0, picture.shape[1] / _SMALL_WIDTH)
    (width, height), below = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, scale, 1)
    cv2.rectangle(picture, (0, 0), (width + 4, height + below + 4), _BACKGROUND, cv2.FILLED)
    cv2.putText(picture, text, (2, height + 2), cv2.FONT_HERSHEY_SIMPLEX, scale, (255, 255, 255), 1, cv2.LINE_AA)
