"""The table holds the errors and both poses of each stamp."""

import csv
import math

import pytest

from shirube_bags.accuracy import compare_trajectories
from shirube_bags.commands.check import save_error_table
from shirube_bags.trajectory import planar_trajectory


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
