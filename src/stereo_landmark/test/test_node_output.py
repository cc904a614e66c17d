from dataclasses import replace

import numpy as np
import pytest
from located_pairs import detection, with_fix, without_fix
from std_msgs.msg import Header
from taught_wall import HERE, METERS
from visualization_msgs.msg import Marker

from shirube_ros.diagnostics import Level
from stereo_landmark.node_output import LocalizerReport, debug_picture, target_markers

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


def test_points_too_far_away_to_be_measured_and_old_ones_are_left_out():
    pair = with_fix()
    seen = pair.result.detections[0]
    seen.points.pixels[1, 2] = seen.points.pixels[1, 0]
    _, points, _ = target_markers(pair, HEADER).markers
    assert len(points.points) == 3
    seen.points.pixels[:, 2] = seen.points.pixels[:, 0]
    for without in (pair, without_fix()):
        (marker,) = target_markers(without, HEADER).markers
        assert marker.action == Marker.DELETEALL


def test_points_are_marked_where_they_are_seen_used_ones_in_another_colour():
    picture = debug_picture(with_fix()).astype(int)
    colours = [picture[v, u] for u, v in np.rint(detection().points.pixels[:, :2]).astype(int)]
    assert [bool(colour[1] > colour[0]) for colour in colours] == [True] * 4
    assert [bool(colour[2] > 200) for colour in colours] == [False, False, False, True]


def test_without_a_fix_there_is_only_the_reason():
    picture = debug_picture(without_fix())
    assert (picture[30:] == 100).all()
    assert (picture[:30] != 100).any()


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


def status_after(*pairs):
    """Return level, message and values that are reported after some results."""
    report = LocalizerReport('places', Clock())
    for pair in pairs:
        report.add(pair, 0.0521)
    status = report.status()
    return status.level, status.message, status.values


def test_missing_and_stopped_pairs_are_reported():
    clock = Clock()
    report = LocalizerReport('places', clock)
    assert (report.status().level, report.status().message[:13]) == (Level.WARN, 'no image pair')
    report.add(with_fix(), 0.05)
    assert (report.status().level, report.status().message) == (Level.OK, 'at wall')
    clock.now = 3.0
    assert (report.status().level, report.status().message[:17]) == (Level.WARN, 'image pairs timed')


def test_a_pair_without_a_fix_is_reported_with_its_reason():
    level, message, values = status_after(with_fix(), without_fix())
    assert (level, message) == (Level.WARN, 'no fix: no similar shapes in view')
    assert values['pairs at wall'] == values['pairs without: no similar shapes in view'] == '1'
    assert values['detail'] == 'place wall: meters'


def test_a_missing_imu_reading_is_reported():
    level, message, _ = status_after(replace(with_fix(), is_tilt_missing=True))
    assert (level, message[:22]) == (Level.WARN, 'at wall, assumed level')
    _, _, values = status_after(replace(without_fix(), is_tilt_missing=True))
    assert values['tilt'] == 'assumed level'


def test_a_fix_is_reported_with_its_values():
    pair = with_fix()
    patches = replace(pair, result=replace(pair.result, matched_patches=('panel/a', 'panel/b')))
    assert status_after(patches)[2]['measured by patches'] == 'panel/a, panel/b'
    assert status_after(pair)[2].items() >= {
        ('targets found', 'meters'),
        ('measured by patches', 'none; measured by outlines'),
        ('points used', '3'),
        ('x, y, yaw', '0.1500 m, -0.1000 m, 0.0600 rad'),
        ('sigma x, y, yaw', '0.0010 m, 0.0020 m, 0.0100 rad'),
        ('processing time [ms]', '52.1'),
    }
