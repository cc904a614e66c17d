"""The command check."""

import csv
import json
import math

import numpy as np
import pytest

from shirube_bags.accuracy import compare_trajectories
from shirube_bags.bag_writer import BagWriter
from shirube_bags.commands.check import load_intervals, main, save_error_table
from shirube_bags.errors import TrajectoryError
from shirube_bags.trajectory import planar_trajectory
from shirube_bags.trajectory_files import load_tum, save_tum

START_NS = 1_700_000_000_123_456_789


@pytest.fixture
def run_path(tmp_path, messages):
    """Poses with an error of 2 mm, for all images of ``bag_path`` except the first and the last."""
    path = tmp_path / 'run'
    with BagWriter(path) as bag:
        for index in range(1, 40):
            stamp = START_NS + index * 20_000_000
            pose = messages.pose(stamp, 0.01 * (index - 0.5), 0.002, 0.1)
            bag.write('/floor_localizer/pose', 'geometry_msgs/msg/PoseStamped', pose, stamp + 5_000_000)
    return path


def check(*arguments):
    return main([str(each) for each in arguments])


def test_a_run_is_compared_with_the_truth_of_another_bag(run_path, bag_path, tmp_path, capsys):
    figures, table = tmp_path / 'figures.json', tmp_path / 'errors.csv'
    options = ['--images', '/image_raw', '--json', figures, '--csv', table]
    assert check(run_path, '--reference', bag_path, *options) == 0
    found = json.loads(figures.read_text())
    assert (found['position']['rms'], found['position']['max']) == pytest.approx((0.002, 0.002))
    assert found['heading']['max'] == pytest.approx(0.0, abs=1e-9)
    assert (found['coverage']['covered'], found['coverage']['expected']) == (39, 41)
    with table.open() as file:
        assert len(list(csv.DictReader(file))) == 39
    assert '2.000' in capsys.readouterr().out


def test_tum_files_hold_both_at_the_same_stamps(run_path, bag_path, tmp_path):
    assert check(run_path, '--reference', bag_path, '--tum', tmp_path / 'tum') == 0
    estimate, reference = (load_tum(tmp_path / 'tum' / name) for name in ('estimate.tum', 'reference.tum'))
    np.testing.assert_array_equal(estimate.stamps_ns, reference.stamps_ns)
    np.testing.assert_allclose(estimate.positions - reference.positions, [[0, 0.002, 0]] * 39, atol=1e-12)
    assert check(tmp_path / 'tum' / 'estimate.tum', '--reference', tmp_path / 'tum' / 'reference.tum') == 0


def test_excluded_intervals_raise_the_coverage(run_path, bag_path, tmp_path):
    (tmp_path / 'dirt.csv').write_text(f'start,end\n{START_NS / 1e9 - 1:.3f},{START_NS / 1e9 + 0.001:.3f}\n')
    options = ['--images', '/image_raw', '--exclude', tmp_path / 'dirt.csv', '--json', tmp_path / 'a.json']
    assert check(run_path, '--reference', bag_path, *options) == 0
    coverage = json.loads((tmp_path / 'a.json').read_text())['coverage']
    assert (coverage['covered'], coverage['expected'], coverage['excluded']) == (39, 40, 1)


@pytest.mark.parametrize(
    ('option', 'kept', 'broken'), [('--max-position-p95', 0.0021, 0.0019), ('--min-coverage', 0.95, 0.96)]
)
def test_a_regression_ends_with_exit_code_1(run_path, bag_path, capsys, option, kept, broken):
    options = ['--reference', bag_path, '--images', '/image_raw', option]
    assert check(run_path, *options, kept) == 0
    assert capsys.readouterr().err == ''
    assert check(run_path, *options, broken) == 1
    assert 'limit' in capsys.readouterr().err


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['{tmp}/none.tum', '--reference', '{tmp}/a.tum'], 'none.tum: cannot be read'),
        (['{tmp}/a.tum', '--json', '{tmp}/a.tum/a.json'], 'choose a writable place'),
        (['{tmp}/a.tum', '--images', '/image_raw'], 'is not a bag'),
    ],
)
def test_bad_input_ends_in_one_line(tmp_path, capsys, arguments, words):
    save_tum(tmp_path / 'a.tum', planar_trajectory([0, 10], np.zeros((2, 3))))
    assert check(*(argument.format(tmp=tmp_path) for argument in arguments)) == 1
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert words in line


def test_each_row_holds_its_errors_and_poses(tmp_path):
    stamps = [1_700_000_000_000_000_001, 1_700_000_000_100_000_000]
    reference = planar_trajectory(stamps, [[1, 2, 0.5], [1, 2, -0.5]])
    estimate = planar_trajectory(stamps, [[1.3, 2.4, 0.6], [1, 2, -0.7]])
    save_error_table(tmp_path / 'errors.csv', compare_trajectories(estimate, reference, 1.0))
    with (tmp_path / 'errors.csv').open() as file:
        rows = list(csv.DictReader(file))
    assert [row['stamp'] for row in rows] == ['1700000000.000000001', '1700000000.100000000']
    for row, yaw_error in zip(rows, [0.1, -0.2]):
        number = {name: float(value) for name, value in row.items()}
        shift = math.hypot(number['x'] - number['reference_x'], number['y'] - number['reference_y'])
        assert number['position_error'] == pytest.approx(shift, abs=1e-8)
        assert number['heading_error'] == pytest.approx(number['yaw'] - number['reference_yaw'], abs=1e-8)
        assert number['heading_error'] == pytest.approx(yaw_error)


def test_intervals_are_read_and_other_columns_left_alone(tmp_path):
    (tmp_path / 'dirt.csv').write_text('name,start,end\nmud,1.5,2\nleaf,1700000000.000000001,1700000001\n')
    assert load_intervals(tmp_path / 'dirt.csv').tolist() == [
        [1_500_000_000, 2_000_000_000],
        [1_700_000_000_000_000_001, 1_700_000_001_000_000_000],
    ]
    (tmp_path / 'dirt.csv').write_text('start,end\n')
    assert load_intervals(tmp_path / 'dirt.csv').shape == (0, 2)


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        (None, 'cannot be read'),
        ('', 'no columns start and end'),
        ('1,2\n', 'no columns start and end'),
        ('start,end\n1,2\n3\n', 'line 3: .* no time'),
        ('start,end\n1,nan\n', 'line 2: .*nan.* no time'),
        ('start,end\n2,1\n', 'line 2: ends before it starts'),
    ],
)
def test_malformed_files_are_refused(tmp_path, text, message):
    if text is not None:
        (tmp_path / 'dirt.csv').write_text(text)
    with pytest.raises(TrajectoryError, match=message):
        load_intervals(tmp_path / 'dirt.csv')
