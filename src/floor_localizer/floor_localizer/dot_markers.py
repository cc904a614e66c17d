"""The dots of an image as RViz markers."""

from __future__ import annotations

import numpy as np
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from floor_localizer.core.fix import Fix
from shirube_core.geometry import CameraMount, PinholeCamera

_MATCHED = ColorRGBA(r=0.1, g=0.8, b=0.2, a=1.0)
_UNMATCHED = ColorRGBA(r=0.9, g=0.1, b=0.1, a=1.0)


def dot_markers(fix: Fix, camera: PinholeCamera, mount: CameraMount, header: Header) -> MarkerArray:
    """Return markers at the image's dots on the map: matched ones green, the others red.

    Args:
        fix: pose and dots of the image.
        camera: the camera's intrinsics.
        mount: nominal pose of the camera on the robot.
        header: stamp of the image, map frame.
    """
    points_base = mount.floor_points_from_rays(camera.rays_from_pixels(fix.dots.pixels))
    points_map = fix.T_map_base.transform(points_base)
    metres_per_pixel = mount.xyz[2] / camera.fx
    diameter = float(np.median(fix.dots.diameters)) * metres_per_pixel
    groups = (('matched', _MATCHED, fix.matched), ('unmatched', _UNMATCHED, ~fix.matched))
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
