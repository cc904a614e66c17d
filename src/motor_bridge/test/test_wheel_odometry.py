import math

import numpy as np
import pytest

from motor_bridge.core.encoder_odometry import WheelOdometry, velocity_from_distances
from shirube_core.geometry import SE2

B = 0.2


def moved(ways, noise=0.01):
    odometry = WheelOdometry(B, noise)
    for left, right in ways:
        odometry.move(left, right)
    return odometry


def test_equal_ways_go_straight_and_opposite_ones_turn():
    assert moved([(0.4, 0.4)]).T_odom_base == SE2(0.4, 0.0, 0.0)
    turned = moved([(-0.1, 0.1)]).T_odom_base
    assert (turned.x, turned.y, turned.yaw) == pytest.approx((0.0, 0.0, 0.2 / B))


@pytest.mark.parametrize('parts', [1, 7, 1000])
def test_an_arc_is_the_same_in_one_step_as_in_many(parts):
    pose = moved([(0.2 / parts, 0.3 / parts)] * parts).T_odom_base
    turn, radius = 0.1 / B, 0.25 * B / 0.1
    end = (radius * math.sin(turn), radius * (1.0 - math.cos(turn)), turn)
    assert (pose.x, pose.y, pose.yaw) == pytest.approx(end)


def test_driving_back_comes_back():
    pose = moved([(0.2, 0.3), (-0.1, 0.4), (0.1, -0.4), (-0.2, -0.3)]).T_odom_base
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


def test_the_covariance_is_that_of_many_noisy_drives():
    rng = np.random.default_rng(2)
    noise, ways = 0.01, [(0.05, 0.06)] * 30
    ends = []
    for _ in range(1000):
        real = [(w + noise * math.sqrt(w) * rng.normal()) for pair in ways for w in pair]
        pose = moved(zip(real[::2], real[1::2], strict=True)).T_odom_base
        ends.append((pose.x, pose.y, pose.yaw))
    said, seen = moved(ways, noise).covariance, np.cov(np.array(ends).T)
    np.testing.assert_allclose(np.sqrt(np.diag(said)), np.sqrt(np.diag(seen)), rtol=0.12)
    covariance = moved([(0.02, 0.021)] * 5000).covariance
    assert (np.linalg.eigvalsh(covariance) > 0.0).all()
    np.testing.assert_array_equal(covariance, covariance.T)


def test_a_motion_that_nobody_counted_moves_nothing_and_is_covered():
    odometry = moved([(0.5, 0.6)])
    before = odometry.T_odom_base
    odometry.add_uncounted_motion(0.3, 0.2)
    assert odometry.T_odom_base == before
    sigma = np.sqrt(np.diag(odometry.covariance))
    after = moved([(0.5, 0.6), (0.3, 0.2)]).T_odom_base
    assert before.distance_to(after) < math.hypot(*sigma[:2])
    assert abs(before.yaw_to(after)) < sigma[2]


def test_velocities_and_their_covariance():
    velocity = velocity_from_distances(0.01, 0.03, 0.1, B)
    assert (velocity.forward, velocity.turn_rate) == pytest.approx((0.2, 1.0))
    odometry, rng, tick = WheelOdometry(B, 0.01), np.random.default_rng(3), 1e-3
    samples = []
    for _ in range(4000):
        ways = 0.05 + 0.01 * math.sqrt(0.05) * rng.normal(size=2) + rng.uniform(-0.5, 0.5, (2, 2)).sum(0) * tick
        seen = velocity_from_distances(*ways, 0.1, B)
        samples.append((seen.forward, seen.turn_rate))
    said = odometry.velocity_covariance(0.05, 0.05, 0.1, tick)
    np.testing.assert_allclose(np.diag(said), np.var(samples, axis=0), rtol=0.1)
