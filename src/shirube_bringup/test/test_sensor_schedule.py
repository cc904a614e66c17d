"""Every measurement is published once, in order, for any time step, and never before its time."""

from __future__ import annotations

import pytest

from shirube_bringup.simulator import CAMERAS, STEP_MS, TILT, SensorSchedule


@pytest.mark.parametrize('schedule', [*CAMERAS, TILT, SensorSchedule('odd', 33, 7, 5, 50)])
@pytest.mark.parametrize('step', [1, 7, STEP_MS, 50])
def test_all_come_once(schedule, step):
    end = 2000
    steps = [(now - step, now) for now in range(step, end + step, step)]
    shown = [index for before, now in steps for index in schedule.indices(before, now, schedule.latency)]
    assert shown == list(range(len(shown)))
    last = schedule.time_ms(len(shown)) + schedule.latency
    assert last > end


@pytest.mark.parametrize('schedule', CAMERAS)
def test_a_picture_is_ordered_before_it_is_shown_and_after_its_exposure(schedule):
    ordered: dict[int, int] = {}
    for now in range(STEP_MS, 3000, STEP_MS):
        for index in schedule.indices(now - STEP_MS, now, schedule.exposure):
            assert now >= schedule.time_ms(index) + schedule.exposure
            ordered[index] = now
        for index in schedule.indices(now - STEP_MS, now, schedule.latency):
            assert ordered[index] < now
