"""Laws of poses in space."""

import numpy as np
import pytest

from shirube_core.geometry import SE2, SE3, quaternion_from_yaw, yaw_from_quaternion

RNG = np.random.default_rng(5)
POSES = [SE3.from_rpy(*RNG.uniform(-3.0, 3.0, (2, 3))) for _ in range(10)]
POINTS = RNG.uniform(-1.0, 1.0, (7, 3))


@pytest.mark.parametrize(('a', 'b'), zip(POSES, POSES[1:]))
def test_points_follow_composition_and_inverse(a: SE3, b: SE3) -> None:
    np.testing.assert_allclose((a @ b).transform(POINTS), a.transform(b.transform(POINTS)), atol=1e-12)
    np.testing.assert_allclose(a.inverse().transform(a.transform(POINTS)), POINTS, atol=1e-12)
    np.testing.assert_allclose((a.inverse() @ a).rotation, np.eye(3), atol=1e-12)


@pytest.mark.parametrize('yaw', RNG.uniform(-3.0, 3.0, 5))
def test_a_rotation_about_z_is_that_of_the_plane(yaw: float) -> None:
    in_space = SE3.from_rpy((1.0, 2.0, 3.0), (0.0, 0.0, yaw)).transform(POINTS)
    np.testing.assert_allclose(in_space[:, :2], SE2(1.0, 2.0, yaw).transform(POINTS[:, :2]), atol=1e-12)
    np.testing.assert_allclose(in_space[:, 2], POINTS[:, 2] + 3.0)
    assert yaw_from_quaternion(*quaternion_from_yaw(yaw)) == pytest.approx(yaw)
