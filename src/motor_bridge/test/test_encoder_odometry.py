"""Implausible counts move nothing; plausible ones are not lost."""

import math

import numpy as np
import pytest

from motor_bridge.core.count_watch import RESTART_AFTER, CountVerdict, turns_between
from motor_bridge.core.drive_settings import DriveSettings
from motor_bridge.core.encoder_odometry import EncoderOdometry
from motor_bridge.core.serial_protocol import WheelCounts
from motor_bridge.core.wheel_base import WheelBase

SETTINGS = DriveSettings()
BASE = WheelBase(SETTINGS)
FRAME = 0.033
TICK = BASE.metres_per_tick


class Wheels:
    """Wheels that follow the commands; their counts are read once per frame."""

    def __init__(self, start=0):
        self.odometry = EncoderOdometry(BASE, SETTINGS)
        self.counts, self.now = np.array([start, start]), 10.0
        self.take()

    def take(self, error=(0, 0), later=0.0):
        half = 2**31
        left, right = (int((c + e + half) % (2 * half) - half) for c, e in zip(self.counts, error))
        return self.odometry.take(WheelCounts(left, right), self.now + later)

    def drive(self, left, right, frames=1, read=True):
        verdict = None
        for _ in range(frames):
            self.odometry.reach.command(left, right)
            self.counts += np.array([left, right])
            self.now += FRAME
            if read:
                verdict = self.take()
        return verdict

    @property
    def x(self):
        return self.odometry.state.T_odom_base.x

    @property
    def way(self):
        return self.x / TICK

    @property
    def sigma(self):
        return np.sqrt(np.diag(self.odometry.state.covariance))


def test_the_way_is_what_the_encoders_counted():
    wheels = Wheels(7)
    wheels.drive(40, 40, 100)
    state = wheels.odometry.state
    assert wheels.way == pytest.approx(4000)
    assert state.velocity.forward == pytest.approx(40 * TICK / FRAME)
    assert state.angles == pytest.approx((4000 * math.tau / 1440,) * 2)
    assert state.speeds == pytest.approx((40 * math.tau / 1440 / FRAME,) * 2)


@pytest.mark.parametrize('direction', [1, -1])
def test_counts_wrap_without_a_jump(direction):
    wheels = Wheels(direction * (2**31 - 500))
    wheels.drive(direction * 40, direction * 40, 50)
    assert wheels.way == pytest.approx(direction * 2000)
    assert turns_between(WheelCounts(2**31 - 1, 0), WheelCounts(-(2**31), -1)) == (1, -1)


@pytest.mark.parametrize('error', [(100, 0), (0, -1000), (10**6, 10**6), (0, 2**31), (-60, 0)])
def test_a_wrong_count_is_asked_again_and_moves_nothing(error):
    wheels = Wheels(50_000)
    wheels.drive(40, 40, 10)
    wheels.drive(40, 40, read=False)
    assert wheels.take(error) is CountVerdict.ASK_AGAIN
    assert wheels.way == pytest.approx(400)
    assert wheels.take(later=0.002) is CountVerdict.TAKEN
    assert wheels.way == pytest.approx(440)


def test_two_different_wrong_counts_are_refused_and_the_next_good_ones_bring_all_back():
    wheels = Wheels(50_000)
    wheels.drive(40, 40, 10)
    wheels.drive(40, 40, read=False)
    assert wheels.take((900, 0)) is CountVerdict.ASK_AGAIN
    assert wheels.take((0, 500), 0.002) is CountVerdict.REFUSED
    assert wheels.drive(40, 40) is CountVerdict.TAKEN
    assert wheels.way == pytest.approx(480)


def test_wrong_counts_a_few_times_too_far_apart_do_not_confirm_each_other():
    wheels = Wheels(50_000)
    wheels.drive(0, 0, 5)
    wheels.now += FRAME
    assert wheels.take((100, 0)) is CountVerdict.ASK_AGAIN
    assert wheels.take((160, 0), 0.002) is CountVerdict.REFUSED
    assert wheels.way == 0.0


def test_a_robot_that_is_pushed_is_believed_at_the_second_time():
    wheels = Wheels()
    wheels.drive(0, 0, 5)
    wheels.now += FRAME
    assert wheels.take((60, 60)) is CountVerdict.ASK_AGAIN
    assert wheels.take((62, 62), 0.002) is CountVerdict.TAKEN
    assert wheels.way == pytest.approx(62)


def test_a_wheel_that_is_stuck_is_believed_at_the_second_time():
    wheels = Wheels()
    wheels.drive(60, 60, 10)
    wheels.odometry.reach.command(60, 60)
    wheels.now += 3 * FRAME
    assert wheels.take() is CountVerdict.ASK_AGAIN
    assert wheels.take(later=0.002) is CountVerdict.TAKEN


def test_an_impossible_count_is_refused_even_twice():
    wheels = Wheels(50_000)
    wheels.drive(10, 10, 5)
    wheels.now += FRAME
    assert wheels.take((30_000, 0)) is CountVerdict.ASK_AGAIN
    assert wheels.take((30_000, 0), 0.002) is CountVerdict.REFUSED
    assert wheels.way == pytest.approx(50)


def test_encoders_that_began_anew_without_a_word_are_followed_and_the_covariance_grows():
    wheels = Wheels(50_000)
    wheels.drive(40, 40, 10)
    before, sigma = wheels.x, wheels.sigma
    wheels.counts = np.array([0, 0])
    verdicts = []
    for _ in range(RESTART_AFTER):
        wheels.now += FRAME
        wheels.take()
        verdicts.append(wheels.take(later=0.002))
    assert verdicts == [CountVerdict.REFUSED] * (RESTART_AFTER - 1) + [CountVerdict.RESTARTED]
    assert wheels.x == before
    lost = 40 * RESTART_AFTER * TICK
    assert wheels.sigma[0] > max(sigma[0], lost)
    wheels.drive(20, 20, 5)
    assert wheels.x - before == pytest.approx(100 * TICK)


@pytest.mark.parametrize('gap', [0.1, 1.0, 10.0])
def test_counts_that_continue_after_a_gap_are_moved_by(gap):
    wheels = Wheels(50_000)
    wheels.drive(40, 40, 10)
    frames = round(min(gap, 2.0) / FRAME * 0.91)
    wheels.counts = wheels.counts + 40 * frames
    wheels.now += gap
    verdict = wheels.odometry.resume(WheelCounts(*map(int, wheels.counts)), wheels.now)
    assert verdict is CountVerdict.TAKEN
    assert wheels.way == pytest.approx(400 + 40 * frames)


@pytest.mark.parametrize('start', [50_000, -700, 300, -50_000])
@pytest.mark.parametrize('rolled', [0, 15])
def test_counts_that_began_anew_in_a_gap_make_no_jump(start, rolled):
    wheels = Wheels(start)
    wheels.drive(40, 40, 10)
    before = wheels.x
    wheels.now += 1.5
    verdict = wheels.odometry.resume(WheelCounts(rolled, rolled), wheels.now)
    assert verdict is CountVerdict.RESTARTED
    assert wheels.x == before
    possible = 40 * 1.5 / FRAME * TICK
    assert possible < wheels.sigma[0] < 3.0 * possible
    assert wheels.odometry.state.velocity.forward == 0.0


def test_counts_that_fit_nothing_make_no_jump():
    wheels = Wheels(50_000)
    wheels.drive(40, 40, 10)
    before = wheels.x
    wheels.now += 1.0
    assert wheels.odometry.resume(WheelCounts(123_456, 7), wheels.now) is CountVerdict.RESTARTED
    assert wheels.x == before


def test_a_robot_that_stood_at_zero_goes_on_without_doubt():
    wheels = Wheels(0)
    wheels.now += 5.0
    assert wheels.odometry.resume(WheelCounts(0, 1), wheels.now) is CountVerdict.TAKEN
    assert wheels.sigma[0] < 1e-3


def test_time_that_jumps_makes_no_motion_and_no_certainty():
    wheels = Wheels(50_000)
    wheels.drive(40, 40, 10)
    before, sigma = wheels.x, wheels.sigma
    wheels.odometry.time_jumped()
    wheels.now, wheels.counts = 2.0, wheels.counts + 300
    assert wheels.take() is CountVerdict.TAKEN
    assert wheels.x == before
    assert wheels.sigma[0] > sigma[0] + 300 * TICK


def test_the_origin_can_be_set_anew_while_driving():
    wheels = Wheels()
    wheels.drive(40, 40, 10)
    wheels.odometry.reset()
    wheels.drive(40, 40, 1)
    assert wheels.way == pytest.approx(40)
