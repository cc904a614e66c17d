"""Implausible counts move nothing; plausible ones are not lost."""

import math

import numpy as np
import pytest

from motor_bridge.core.controller_protocol import WheelCounts
from motor_bridge.core.diff_drive_kinematics import DiffDriveKinematics, DriveSettings
from motor_bridge.core.encoder_monitor import RESTART_COUNT, CountStatus, count_difference
from motor_bridge.core.encoder_odometry import EncoderOdometry

SETTINGS = DriveSettings()
BASE = DiffDriveKinematics(SETTINGS)
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
        return self.odometry.update(WheelCounts(left, right), self.now + later)

    def drive(self, left, right, frames=1, read=True):
        status = None
        for _ in range(frames):
            self.odometry.motion_bounds.set_commanded(left, right)
            self.counts += np.array([left, right])
            self.now += FRAME
            if read:
                status = self.take()
        return status

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
    wheels.odometry.reset()
    wheels.drive(40, 40, 1)
    assert wheels.way == pytest.approx(40)


@pytest.mark.parametrize('direction', [1, -1])
def test_counts_wrap_without_a_jump(direction):
    wheels = Wheels(direction * (2**31 - 500))
    wheels.drive(direction * 40, direction * 40, 50)
    assert wheels.way == pytest.approx(direction * 2000)
    assert count_difference(WheelCounts(2**31 - 1, 0), WheelCounts(-(2**31), -1)) == (1, -1)


@pytest.mark.parametrize('error', [(100, 0), (0, -1000), (10**6, 10**6), (0, 2**31), (-60, 0)])
def test_a_wrong_count_is_asked_again_and_moves_nothing(error):
    wheels = Wheels(50_000)
    wheels.drive(40, 40, 10)
    wheels.drive(40, 40, read=False)
    assert wheels.take(error) is CountStatus.RETRY
    assert wheels.way == pytest.approx(400)
    assert wheels.take(later=0.002) is CountStatus.ACCEPTED
    assert wheels.way == pytest.approx(440)


def test_two_different_wrong_counts_are_refused_and_the_next_good_ones_bring_all_back():
    wheels = Wheels(50_000)
    wheels.drive(40, 40, 10)
    wheels.drive(40, 40, read=False)
    assert wheels.take((900, 0)) is CountStatus.RETRY
    assert wheels.take((0, 500), 0.002) is CountStatus.REJECTED
    assert wheels.drive(40, 40) is CountStatus.ACCEPTED
    assert wheels.way == pytest.approx(480)


@pytest.mark.parametrize(
    ('speed', 'errors', 'status', 'way'),
    [
        (0, [(60, 60), (62, 62)], CountStatus.ACCEPTED, 62),  # pushed
        (0, [(100, 0), (160, 0)], CountStatus.REJECTED, 0),  # too far apart to confirm each other
        (10, [(30_000, 0), (30_000, 0)], CountStatus.REJECTED, 50),  # impossible
    ],
)
def test_a_second_read_confirms_only_what_is_possible(speed, errors, status, way):
    wheels = Wheels(50_000)
    wheels.drive(speed, speed, 5)
    wheels.now += FRAME
    assert wheels.take(errors[0]) is CountStatus.RETRY
    assert wheels.take(errors[1], 0.002) is status
    assert wheels.way == pytest.approx(way)


def test_a_stuck_wheel_is_accepted_at_the_second_read():
    wheels = Wheels()
    wheels.drive(60, 60, 10)
    wheels.odometry.motion_bounds.set_commanded(60, 60)
    wheels.now += 3 * FRAME
    assert wheels.take() is CountStatus.RETRY
    assert wheels.take(later=0.002) is CountStatus.ACCEPTED


def test_encoders_that_were_reset_unnoticed_are_followed_and_the_covariance_grows():
    wheels = Wheels(50_000)
    wheels.drive(40, 40, 10)
    before, sigma = wheels.x, wheels.sigma
    wheels.counts = np.array([0, 0])
    status_counts = []
    for _ in range(RESTART_COUNT):
        wheels.now += FRAME
        wheels.take()
        status_counts.append(wheels.take(later=0.002))
    assert status_counts == [CountStatus.REJECTED] * (RESTART_COUNT - 1) + [CountStatus.RESTARTED]
    assert wheels.x == before
    lost = 40 * RESTART_COUNT * TICK
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
    status = wheels.odometry.resume(WheelCounts(*map(int, wheels.counts)), wheels.now)
    assert status is CountStatus.ACCEPTED
    assert wheels.way == pytest.approx(400 + 40 * frames)
    wheels = Wheels(0)  # stopped at zero
    wheels.now += gap
    assert wheels.odometry.resume(WheelCounts(0, 1), wheels.now) is CountStatus.ACCEPTED
    assert wheels.sigma[0] < 1e-3


@pytest.mark.parametrize('start', [50_000, -700, 300, -50_000])
@pytest.mark.parametrize('counts', [(0, 0), (15, 15), (123_456, 7)])
def test_counts_that_were_reset_in_a_gap_or_fit_nothing_make_no_jump(start, counts):
    wheels = Wheels(start)
    wheels.drive(40, 40, 10)
    before = wheels.x
    wheels.now += 1.5
    status = wheels.odometry.resume(WheelCounts(*counts), wheels.now)
    assert status is CountStatus.RESTARTED
    assert wheels.x == before
    possible = 40 * 1.5 / FRAME * TICK
    assert possible < wheels.sigma[0] < 3.0 * possible
    assert wheels.odometry.state.velocity.forward == 0.0


def test_time_that_jumps_makes_no_motion_and_no_certainty():
    wheels = Wheels(50_000)
    wheels.drive(40, 40, 10)
    before, sigma = wheels.x, wheels.sigma
    wheels.odometry.handle_time_jump()
    wheels.now, wheels.counts = 2.0, wheels.counts + 300
    assert wheels.take() is CountStatus.ACCEPTED
    assert wheels.x == before
    assert wheels.sigma[0] > sigma[0] + 300 * TICK
