"""The paper's room and run; mirrors and mains."""

import math

import numpy as np
import pytest

from scene_simulator.ceiling.camera import PAPER_OPTICS
from scene_simulator.ceiling.lamp_drive import (
    LAMP_A,
    LAMP_B,
    PAPER_LAMPS,
    distractors,
    mains_flicker,
    paper_room,
    paper_run,
)
from scene_simulator.ceiling.room import CeilingRoom
from scene_simulator.errors import SceneError
from shirube_core.waveform import steady_light

WAVEFORMS = [steady_light() for _ in range(4)]


def test_more_lights_come_after_the_lamps_and_the_ceiling_hangs_just_above_them() -> None:
    room = paper_room(WAVEFORMS).with_ambient_light(10.0).with_lights(distractors())
    assert room.lamps[:4] == paper_room(WAVEFORMS).lamps
    assert len(room.lamps) == 8
    assert 0.0 < room.surface.height - 2.5 < 0.05
    assert room.surface.ambient == 10.0


def test_wrong_rooms_are_refused() -> None:
    with pytest.raises(SceneError, match='4 waveforms'):
        paper_room(WAVEFORMS[:3])
    with pytest.raises(SceneError, match='lamp'):
        CeilingRoom().with_ambient_light(1.0)


def test_the_mains_flicker_a_hundred_times_a_second() -> None:
    flicker = mains_flicker(100.0, 0.3)
    times = np.linspace(0.0, 0.05, 500)
    levels = flicker.mean_levels(times, times + 1e-4)[:, 0]
    assert flicker.period == pytest.approx(0.01)
    assert levels.max() == pytest.approx(1.0, abs=0.01)
    assert levels.min() == pytest.approx(0.7, abs=0.01)
    assert flicker.mean_levels(0.0, 0.01)[0] == pytest.approx(0.85, abs=1e-6)


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
    places = np.array([(pose.x, pose.y) for pose in POSES])
    assert ((places > (-2.6, -2.1)) & (places < (4.4, 3.9))).all()  # in the room
    assert POSES[0].yaw == 0.0
    assert POSES[(a + b) // 2].yaw == pytest.approx(-0.5 * math.pi)
    assert abs(POSES[-1].yaw) == pytest.approx(math.pi)


def test_it_is_slow_between_a_and_b_and_fast_after() -> None:
    a, b = nearest(LAMP_A), nearest(LAMP_B)
    ways = np.array([one.distance_to(other) for one, other in zip(POSES[:-1], POSES[1:])]) / 0.05
    assert ways[: a - 20].max() == pytest.approx(0.25, rel=1e-3)
    assert ways[a + 5 : b - 5] == pytest.approx(0.125, rel=1e-2)
    assert ways[b:].max() == pytest.approx(0.25, rel=1e-3)


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
