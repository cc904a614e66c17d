"""Every measurement is published once, in order, for any time step, and never before its time."""

from __future__ import annotations

import pytest

from shirube_mission.sensor_schedule import CAMERAS, STEP_MS, TILT, SensorRhythm


@pytest.mark.parametrize('rhythm', [*CAMERAS, TILT, SensorRhythm('odd', 33, 7, 5, 50)])
@pytest.mark.parametrize('step', [1, 7, STEP_MS, 50])
def test_all_come_once(rhythm, step):
    end = 2000
    steps = [(now - step, now) for now in range(step, end + step, step)]
    shown = [index for before, now in steps for index in rhythm.indices(before, now, rhythm.latency)]
    assert shown == list(range(len(shown)))
    last = rhythm.time_ms(len(shown)) + rhythm.latency
    assert last > end


@pytest.mark.parametrize('rhythm', CAMERAS)
def test_a_picture_is_ordered_before_it_is_shown_and_after_its_exposure(rhythm):
    ordered: dict[int, int] = {}
    for now in range(STEP_MS, 3000, STEP_MS):
        for index in rhythm.indices(now - STEP_MS, now, rhythm.exposure):
            assert now >= rhythm.time_ms(index) + rhythm.exposure
            ordered[index] = now
        for index in rhythm.indices(now - STEP_MS, now, rhythm.latency):
            assert ordered[index] < now
