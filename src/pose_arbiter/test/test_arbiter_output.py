"""No tick is skipped or repeated."""

from pose_arbiter.arbiter_output import TickSchedule

PERIOD = 20_000_000


def test_late_calls_catch_up():
    schedule = TickSchedule(50.0)
    ticks = [t for now in (1_000_000_001, 1_019_999_999, 1_020_000_000, 1_110_000_000) for t in schedule.due(now)]
    assert ticks == [PERIOD * k for k in range(50, 56)]


def test_a_day_has_so_many_ticks_whatever_the_calls():
    schedule, count = TickSchedule(30.0), 0
    for now in range(1, 600_000_000_000, 49_000_001):
        count += len(schedule.due(now))
    assert abs(count - 600 * 30) <= 2


def test_what_is_due_for_long_is_left_out_and_after_a_jump_back_it_goes_on():
    schedule = TickSchedule(50.0)
    schedule.due(1_000_000_000)
    assert len(schedule.due(100_000_000_000)) == 25
    assert len(schedule.due(1_000_000_000)) == 0
    schedule.reset()
    assert len(schedule.due(1_000_000_000)) == 1
