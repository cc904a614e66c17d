"""Errors, coverage, report and limits."""

import json
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shirube_bags.accuracy import (
    compare_trajectories,
    compute_coverage,
    error_statistics,
    exceeded_limits,
    format_report,
    make_report,
    report_to_dict,
)
from shirube_bags.errors import TrajectoryError
from shirube_bags.trajectory import Trajectory, planar_trajectory
from shirube_bags.trajectory_files import save_tum

RNG = np.random.default_rng(7)
STAMPS = 1_700_000_000_000_000_000 + np.arange(200) * 50_000_000


def drive(seconds):
    return np.column_stack([np.cos(seconds), 0.5 * seconds, 2.0 * seconds])


def true_drive():
    return planar_trajectory(STAMPS, drive((STAMPS - STAMPS[0]) / 1e9))


def noisy_drive():
    stamps = STAMPS[:-1] + 7_000_000
    poses = drive((stamps - STAMPS[0]) / 1e9) + RNG.normal(0.0, [0.01, 0.01, 0.02], (len(stamps), 3))
    return planar_trajectory(stamps, poses)


def moved(trajectory: Trajectory, rotation: Rotation, shift) -> Trajectory:
    turns = rotation * Rotation.from_quat(trajectory.quaternions)
    places = rotation.apply(trajectory.positions) + np.asarray(shift)
    return Trajectory(trajectory.stamps_ns, places, turns.as_quat())


def test_a_trajectory_has_no_error_against_itself():
    errors = compare_trajectories(true_drive(), true_drive(), 0.5)
    assert errors.position.max() < 1e-12
    assert np.abs(errors.heading).max() < 1e-12
    assert errors.unmatched == 0


@pytest.mark.parametrize('seed', range(3))
def test_a_rigid_motion_of_both_leaves_the_errors_alone(seed):
    rotation, shift = Rotation.random(random_state=seed), RNG.uniform(-10, 10, 3)
    estimate, reference = noisy_drive(), true_drive()
    before = compare_trajectories(estimate, reference, 0.5)
    after = compare_trajectories(moved(estimate, rotation, shift), moved(reference, rotation, shift), 0.5)
    np.testing.assert_allclose(after.position, before.position, atol=1e-9)
    np.testing.assert_allclose(after.heading, before.heading, atol=1e-9)


def test_a_known_offset_is_exactly_the_error():
    reference = true_drive()
    turn = Rotation.from_euler('z', -0.02)
    turned = Rotation.from_quat(reference.quaternions) * turn
    estimate = Trajectory(STAMPS, reference.positions + np.array([0.003, -0.004, 0.0]), turned.as_quat())
    errors = compare_trajectories(estimate, reference, 0.5)
    np.testing.assert_allclose(errors.position, 0.005, rtol=1e-9)
    np.testing.assert_allclose(errors.heading, -0.02, rtol=1e-9)


def test_the_heading_error_wraps_at_pi():
    reference = planar_trajectory([0, 10], [[0, 0, math.pi - 0.01]] * 2)
    estimate = planar_trajectory([0, 10], [[0, 0, -math.pi + 0.02]] * 2)
    np.testing.assert_allclose(compare_trajectories(estimate, reference, 1.0).heading, 0.03, atol=1e-12)


def test_the_errors_do_not_depend_on_how_densely_a_straight_reference_is_sampled():
    dense = planar_trajectory(np.arange(0, 101) * 10**7, np.linspace([0, 0, 0], [1, 2, 0.5], 101))
    sparse = dense.select(np.arange(101) % 20 == 0)
    estimate = planar_trajectory([105_000_000, 333_333_333], [[0.1, 0.2, 0.0], [0.5, 0.5, 0.1]])
    one, other = (compare_trajectories(estimate, reference, 0.5) for reference in (dense, sparse))
    np.testing.assert_allclose(one.position, other.position, atol=1e-12)
    np.testing.assert_allclose(one.heading, other.heading, atol=1e-12)


def test_poses_without_a_true_pose_are_counted():
    estimate = planar_trajectory(STAMPS + 3_000_000_000, np.zeros((200, 3)))
    errors = compare_trajectories(estimate, true_drive(), 0.5)
    assert (len(errors.estimate), errors.unmatched) == (140, 60)


def test_trajectories_of_different_times_are_refused():
    with pytest.raises(TrajectoryError, match='no stamps in common; check'):
        compare_trajectories(planar_trajectory([1, 2], np.zeros((2, 3))), true_drive(), 0.5)


def test_the_position_error_is_the_absolute_pose_error_of_evo(tmp_path):
    metrics = pytest.importorskip('evo.core.metrics')
    file_interface = pytest.importorskip('evo.tools.file_interface')
    errors = compare_trajectories(noisy_drive(), true_drive(), 0.5)
    save_tum(tmp_path / 'estimate.tum', errors.estimate)
    save_tum(tmp_path / 'reference.tum', errors.reference)
    names = [str(tmp_path / name) for name in ('reference.tum', 'estimate.tum')]
    pair = tuple(file_interface.read_tum_trajectory_file(name) for name in names)
    for relation, sizes in (('translation_part', errors.position), ('rotation_angle_rad', errors.heading)):
        ape, ours = metrics.APE(metrics.PoseRelation[relation]), error_statistics(sizes)
        ape.process_data(pair)
        evo = ape.get_all_statistics()
        assert (ours.rms, ours.median, ours.max) == pytest.approx((evo['rmse'], evo['median'], evo['max']))
        assert ours.p95 == pytest.approx(np.percentile(np.abs(sizes), 95))


@pytest.fixture
def report():
    """Ten poses, each 3 mm and 0.5 degrees off; one of eleven expected is missing."""
    stamps = np.arange(10) * 10**8
    reference = planar_trajectory(stamps, np.zeros((10, 3)))
    estimate = planar_trajectory(stamps, np.tile([0.003, 0.0, math.radians(0.5)], (10, 1)))
    expected = np.arange(11) * 10**8
    coverage = compute_coverage(expected, stamps, 0, np.empty((0, 2), dtype=np.int64))
    return make_report(compare_trajectories(estimate, reference, 0.5), coverage, '/image_raw')


def test_the_json_is_in_metres_and_radians(report):
    figures = json.loads(json.dumps(report_to_dict(report)))
    assert figures['position']['rms'] == pytest.approx(0.003)
    assert figures['heading']['max'] == pytest.approx(math.radians(0.5))
    assert figures['coverage']['missing'] == [1.0]
    assert figures['compared'] == 10


def test_the_text_is_in_millimetres_and_degrees(report):
    header, position, heading, *rest = format_report(report).splitlines()
    assert header.split() == ['error', 'median', 'rms', 'p95', 'max']
    assert position.split() == ['position', '[mm]'] + ['3.000'] * 4
    assert heading.split() == ['heading', '[deg]'] + ['0.500'] * 4
    assert '10 of 11 stamps of /image_raw' in rest[0]


@pytest.mark.parametrize(
    ('name', 'limit', 'words'),
    [('position_median', 0.0029, 'more'), ('heading_rms', 0.008, 'more'), ('coverage', 0.95, 'less')],
)
def test_only_a_broken_limit_is_named(report, name, limit, words):
    kept = {'position_rms': 0.0031, 'position_max': 0.0031, 'heading_p95': 0.009, 'position_p95': 1.0}
    (line,) = exceeded_limits(report, {name: limit, **kept})
    assert line.startswith(f'{name} is ')
    assert f'{words} than the limit {limit}' in line


@pytest.mark.parametrize(
    ('expected', 'poses', 'tolerance', 'intervals', 'counts', 'missing'),
    [
        ([0, 100, 200, 300], [1, 99, 206, 1000], 5, [], (4, 2, 0), [200, 300]),
        # The ends of an interval are excluded, too; of two intervals, a stamp once.
        (range(0, 1000, 100), [0, 100], 0, [[200, 400], [900, 950]], (6, 2, 4), [500, 600, 700, 800]),
        ([300], [0], 0, [[0, 500], [100, 1000]], (0, 0, 1), []),
    ],
)
def test_stamps_with_a_near_pose_are_covered(expected, poses, tolerance, intervals, counts, missing):
    excluded = np.array(intervals, dtype=np.int64).reshape(-1, 2)
    coverage = compute_coverage(np.array(expected), np.array(poses), tolerance, excluded)
    assert (coverage.expected, coverage.covered, coverage.excluded) == counts
    assert coverage.missing_ns.tolist() == missing
    assert coverage.fraction == (counts[1] / counts[0] if counts[0] else 1.0)
