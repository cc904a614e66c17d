"""Markers are at the positions of the dots on the map."""

import numpy as np
import pytest
from localizer_results import CAMERA, MOUNT, POSE, a_fix
from std_msgs.msg import Header
from visualization_msgs.msg import Marker

from floor_localizer.localization.visualization import delete_markers, dot_markers


def test_each_dot_is_a_marker_whose_image_is_the_dot():
    fix = a_fix()
    markers = dot_markers(fix, CAMERA, MOUNT, Header(frame_id='map')).markers
    assert {marker.header.frame_id for marker in markers} == {'map'}
    for marker, chosen in zip(markers, (fix.matched, ~fix.matched), strict=True):
        points_map = [(point.x, point.y) for point in marker.points]
        points_base = POSE.inverse().transform(points_map)
        pixels = CAMERA.pixels_from_points(MOUNT.camera_points_from_floor(points_base))
        np.testing.assert_allclose(pixels, fix.dots.pixels[chosen], atol=1e-6)


def test_markers_are_as_large_as_the_dots():
    marker = dot_markers(a_fix(), CAMERA, MOUNT, Header()).markers[0]
    assert marker.scale.x == pytest.approx(8.0 * 0.09 / 235.0, rel=0.01)


def test_without_a_fix_the_old_markers_go_away():
    assert [marker.action for marker in delete_markers(Header()).markers] == [Marker.DELETEALL]
