"""Intervals come from a CSV file with two columns."""

import pytest

from shirube_bags.commands.check import load_intervals
from shirube_bags.errors import TrajectoryError


def test_intervals_are_read_and_other_columns_left_alone(tmp_path):
    (tmp_path / 'dirt.csv').write_text('name,start,end\nmud,1.5,2\nleaf,1700000000.000000001,1700000001\n')
    assert load_intervals(tmp_path / 'dirt.csv').tolist() == [
        [1_500_000_000, 2_000_000_000],
        [1_700_000_000_000_000_001, 1_700_000_001_000_000_000],
    ]


def test_no_interval_is_fine(tmp_path):
    (tmp_path / 'dirt.csv').write_text('start,end\n')
    assert load_intervals(tmp_path / 'dirt.csv').shape == (0, 2)


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('', 'no columns start and end'),
        ('1,2\n', 'no columns start and end'),
        ('start,end\n1,2\n3\n', 'line 3: .* no time'),
        ('start,end\n1,nan\n', 'line 2: .*nan.* no time'),
        ('start,end\n2,1\n', 'line 2: ends before it starts'),
    ],
)
def test_malformed_files_are_refused(tmp_path, text, message):
    (tmp_path / 'dirt.csv').write_text(text)
    with pytest.raises(TrajectoryError, match=message):
        load_intervals(tmp_path / 'dirt.csv')


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(TrajectoryError, match='cannot be read'):
        load_intervals(tmp_path / 'none.csv')
