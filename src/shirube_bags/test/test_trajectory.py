"""Laws of trajectories."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shirube_bags.errors import TrajectoryError
from shirube_bags.trajectory import can_interpolate, interpolate, make_trajectory, planar_trajectory

RNG = np.random.default_rng(5)
STAMPS = 1_700_000_000 * 10**9 + np.cumsum(RNG.integers(1, 10**8, 50))


def random_trajectory():
    turns = Rotation.random(len(STAMPS), random_state=3).as_quat()
    return make_trajectory(STAMPS, RNG.uniform(-5, 5, (len(STAMPS), 3)), turns)


def test_the_order_of_the_poses_does_not_matter():
    trajectory, order = random_trajectory(), RNG.permutation(len(STAMPS))
    shuffled = make_trajectory(STAMPS[order], trajectory.positions[order], trajectory.quaternions[order])
    np.testing.assert_array_equal(shuffled.stamps_ns, trajectory.stamps_ns)
    np.testing.assert_array_equal(shuffled.positions, trajectory.positions)


def test_interpolation_at_its_own_stamps_gives_the_trajectory():
    trajectory = random_trajectory()
    same = interpolate(trajectory, trajectory.stamps_ns)
    np.testing.assert_allclose(same.positions, trajectory.positions, atol=1e-12)
    turns = Rotation.from_quat(same.quaternions).inv() * Rotation.from_quat(trajectory.quaternions)
    assert turns.magnitude().max() < 1e-12


def test_interpolation_of_uniform_motion_is_exact_through_the_turn_of_pi():
    stamps = np.arange(0, 10**10, 10**9)
    seconds = stamps / 1e9
    poses = np.column_stack([0.3 * seconds, -0.1 * seconds, 2.0 + 0.5 * seconds])
    between = np.sort(RNG.integers(0, 9 * 10**9, 40))
    found = interpolate(planar_trajectory(stamps, poses), between)
    wanted = planar_trajectory(
        between, np.column_stack([0.3 * between / 1e9, -0.1 * between / 1e9, 2.0 + 0.5 * between / 1e9])
    )
    np.testing.assert_allclose(found.positions, wanted.positions, atol=1e-12)
    turns = Rotation.from_quat(found.quaternions).inv() * Rotation.from_quat(wanted.quaternions)
    assert turns.magnitude().max() < 1e-9


def test_only_stamps_between_near_poses_are_known():
    trajectory = planar_trajectory([10, 20, 100], np.zeros((3, 3)))
    asked = np.array([9, 10, 15, 20, 21, 99, 100, 101])
    assert can_interpolate(trajectory, asked, 10).tolist() == [0, 1, 1, 1, 0, 0, 1, 0]
    assert can_interpolate(trajectory, asked, 79).tolist() == [0, 1, 1, 1, 0, 0, 1, 0]
    assert can_interpolate(trajectory, asked, 80).tolist() == [0, 1, 1, 1, 1, 1, 1, 0]


def test_a_single_pose_is_known_at_its_stamp():
    single = planar_trajectory([10], [[1.0, 2.0, 3.0]])
    assert can_interpolate(single, np.array([9, 10, 11]), 100).tolist() == [0, 1, 0]
    np.testing.assert_allclose(interpolate(single, np.array([10])).positions, [[1.0, 2.0, 0.0]])


def test_nothing_is_extrapolated():
    with pytest.raises(TrajectoryError, match='outside'):
        interpolate(planar_trajectory([10, 20], np.zeros((2, 3))), np.array([15, 21]))


@pytest.mark.parametrize(
    ('stamps', 'positions', 'quaternions', 'message'),
    [
        ([], [], [], 'no poses'),
        ([1, 2], [[0, 0, 0], [0, np.nan, 0]], [[0, 0, 0, 1]] * 2, 'pose 2 of 2 has a position'),
        ([1, 2], [[0, 0, 0], [0, 0, 0]], [[0, 0, 0, 0], [0, 0, 0, 1]], 'pose 1 of 2 has a quaternion'),
        ([1, 2], [[0, 0, 0], [0, 0, 0]], [[0, 0, 0, 1], [0, 0, np.nan, 1]], 'pose 2 of 2 has a quaternion'),
        ([1, 1], [[0, 0, 0], [0, 0, 0]], [[0, 0, 0, 1]] * 2, 'two poses have the stamp 1 ns'),
        ([1, 2], [[0, 0], [0, 0]], [[0, 0, 0, 1]] * 2, 'need x, y, z'),
    ],
)
def test_malformed_poses_are_refused(stamps, positions, quaternions, message):
    with pytest.raises(TrajectoryError, match=message):
        make_trajectory(stamps, positions, quaternions)
