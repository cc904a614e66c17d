"""The paper's run: its path, speeds and the lamps in view."""

from __future__ import annotations

import math

import numpy as np
import pytest

from scene_simulator.ceiling_camera import PAPER_OPTICS
from scene_simulator.ceiling_room import PAPER_AREA, PAPER_LAMPS
from scene_simulator.errors import SceneError
from scene_simulator.paper_run import LAMP_A, LAMP_B, paper_run
from shirube_core.waveform import steady_light

RUN = paper_run([steady_light(2) for _ in range(4)])
END = 36.0
TIMES = np.arange(0.0, END, 0.05)
POSES = [RUN.pose_at(float(time)) for time in TIMES]


def nearest(lamp: int) -> int:
    x, y, _ = PAPER_LAMPS[lamp]
    return int(np.argmin([math.hypot(pose.x - x, pose.y - y) for pose in POSES]))


def test_it_goes_along_x_then_right_under_a_and_right_under_b() -> None:
    a, b = nearest(LAMP_A), nearest(LAMP_B)
    assert 0 < a < b < len(TIMES)
    for index, lamp in ((a, LAMP_A), (b, LAMP_B)):
        assert math.dist((POSES[index].x, POSES[index].y), PAPER_LAMPS[lamp][:2]) < 0.3
    assert POSES[0].yaw == 0.0
    assert POSES[(a + b) // 2].yaw == pytest.approx(-0.5 * math.pi)
    assert abs(POSES[-1].yaw) == pytest.approx(math.pi)


def test_it_is_slow_between_a_and_b_and_fast_after() -> None:
    a, b = nearest(LAMP_A), nearest(LAMP_B)
    ways = np.array([one.distance_to(other) for one, other in zip(POSES[:-1], POSES[1:])]) / 0.05
    assert ways[: a - 20].max() == pytest.approx(0.25, rel=1e-3)
    assert ways[a + 5 : b - 5] == pytest.approx(0.125, rel=1e-2)
    assert ways[b:].max() == pytest.approx(0.25, rel=1e-3)


def test_it_stays_in_the_room() -> None:
    places = np.array([(pose.x, pose.y) for pose in POSES])
    assert (places > PAPER_AREA[0]).all()
    assert (places < PAPER_AREA[1]).all()


def test_each_lamp_is_in_view_for_nine_seconds_before_it_is_reached() -> None:
    size = np.array([PAPER_OPTICS.width, PAPER_OPTICS.height])
    for lamp in (LAMP_A, LAMP_B):
        until = TIMES[nearest(lamp)]
        for time in np.arange(until - 9.0, until, 0.5):
            point = RUN.camera_pose_at(float(time)).camera_points([PAPER_LAMPS[lamp]])
            (pixel,) = PAPER_OPTICS.pixels_from_points(point)
            assert (pixel > 12.0).all()
            assert (pixel < size - 12.0).all()


def test_a_frame_shows_the_lamps_among_other_lights() -> None:
    frame = next(RUN.frames(1.0))
    seen = {projection.lamp for projection in frame.photo.lamp_projections}
    assert {LAMP_A, LAMP_B} <= seen
    assert any(index >= 4 for index in seen)
    assert frame.photo.image.shape == (1024, 1280)
    assert 0.0 < np.median(frame.photo.image) < 20.0


def test_it_needs_four_waveforms() -> None:
    with pytest.raises(SceneError, match='4 waveforms'):
        paper_run([steady_light()])
