"""Laws of planar poses."""

import math

import numpy as np
import pytest

from shirube_core.geometry import SE2, wrap_angle

RNG = np.random.default_rng(3)
POSES = [SE2(*RNG.uniform(-5.0, 5.0, 3)) for _ in range(20)]


def assert_same_pose(left: SE2, right: SE2) -> None:
    assert left.distance_to(right) == pytest.approx(0.0, abs=1e-12)
    assert left.yaw_to(right) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize('pose', POSES)
def test_a_pose_after_its_inverse_is_the_identity(pose: SE2) -> None:
    assert_same_pose(pose @ pose.inverse(), SE2(0.0, 0.0, 0.0))
    assert_same_pose(pose.inverse() @ pose, SE2(0.0, 0.0, 0.0))


@pytest.mark.parametrize(('a', 'b', 'c'), zip(POSES, POSES[1:], POSES[2:]))
def test_composition_is_associative(a: SE2, b: SE2, c: SE2) -> None:
    assert_same_pose((a @ b) @ c, a @ (b @ c))


@pytest.mark.parametrize(('a', 'b'), zip(POSES, POSES[1:]))
def test_points_follow_the_composition(a: SE2, b: SE2) -> None:
    points = RNG.uniform(-1.0, 1.0, (7, 2))
    np.testing.assert_allclose((a @ b).transform(points), a.transform(b.transform(points)), atol=1e-12)


def test_a_quarter_turn_takes_x_to_y() -> None:
    np.testing.assert_allclose(SE2(1.0, 2.0, math.pi / 2).transform([[3.0, 0.0]]), [[1.0, 5.0]])


@pytest.mark.parametrize('angle', RNG.uniform(-50.0, 50.0, 20))
def test_wrapping_keeps_the_direction(angle: float) -> None:
    wrapped = wrap_angle(angle)
    assert -math.pi <= wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle))
    assert math.sin(wrapped) == pytest.approx(math.sin(angle))


@pytest.mark.parametrize('pose', POSES)
def test_exp_and_log_are_inverse(pose: SE2) -> None:
    assert_same_pose(SE2.exp(*pose.log()), pose)
    small = SE2(pose.x, pose.y, 1e-9 * pose.yaw)
    assert_same_pose(SE2.exp(*small.log()), small)
    straight = SE2(pose.x, pose.y, 0.0)
    assert SE2.exp(*straight.log()) == straight


@pytest.mark.parametrize('pose', POSES)
def test_exp_follows_a_constant_twist(pose: SE2) -> None:
    twist = (pose.x, pose.y, 0.6 * pose.yaw)
    step, moved = SE2.exp(*(0.001 * v for v in twist)), SE2(0.0, 0.0, 0.0)
    for _ in range(1000):
        moved = moved @ step
    assert moved.distance_to(SE2.exp(*twist)) < 1e-9
    # Euler's method, which knows no arcs
    x = y = 0.0
    for k in range(1000):
        yaw = 0.001 * (k + 0.5) * twist[2]
        x += 0.001 * (math.cos(yaw) * twist[0] - math.sin(yaw) * twist[1])
        y += 0.001 * (math.sin(yaw) * twist[0] + math.cos(yaw) * twist[1])
    assert math.hypot(x - moved.x, y - moved.y) < 1e-5
