from dataclasses import replace

import numpy as np
import pytest
from located_pairs import HERE, with_fix, without_fix
from std_msgs.msg import Header
from taught_wall import METERS
from visualization_msgs.msg import Marker

from stereo_landmark.node_output import target_markers

HEADER = Header(frame_id='base_link')


def test_points_are_where_the_robot_would_reach_them():
    """In the base frame at HERE the meters have the inverse displacement."""
    _, points, name = target_markers(with_fix(), HEADER).markers
    cos, sin = np.cos(HERE[3]), np.sin(HERE[3])
    for point, meter in zip(points.points, METERS):
        x, y = 3.0 - HERE[0], meter.y - HERE[1]
        assert (point.x, point.y) == pytest.approx((cos * x + sin * y, cos * y - sin * x), abs=0.005)
        assert point.z == pytest.approx(meter.z, abs=0.005)
    assert name.text == 'meters'


def test_the_base_frame_leans_with_the_robot():
    """The same image points give the same markers in the base frame, for any tilt."""
    level, leaning = with_fix(), replace(with_fix(), tilt=(0.1, -0.2))
    expected = target_markers(level, HEADER).markers[1].points
    assert target_markers(leaning, HEADER).markers[1].points == expected


def test_points_too_far_away_to_be_measured_are_left_out():
    pair = with_fix()
    seen = pair.result.detections[0]
    seen.points.pixels[1, 2] = seen.points.pixels[1, 0]
    _, points, _ = target_markers(pair, HEADER).markers
    assert len(points.points) == 3
    seen.points.pixels[:, 2] = seen.points.pixels[:, 0]
    assert len(target_markers(pair, HEADER).markers) == 1


def test_without_targets_the_old_ones_are_removed():
    (marker,) = target_markers(without_fix(), HEADER).markers
    assert marker.action == Marker.DELETEALL
