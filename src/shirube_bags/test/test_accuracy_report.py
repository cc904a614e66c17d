"""Reports show the accuracy of a run, and limits are checked."""

import json
import math

import numpy as np
import pytest

from shirube_bags.accuracy import (
    compare_trajectories,
    compute_coverage,
    exceeded_limits,
    format_report,
    make_report,
    report_to_dict,
)
from shirube_bags.trajectory import planar_trajectory


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


def test_limits_that_hold_are_silent(report):
    kept = {'position_rms': 0.0031, 'position_max': 0.0031, 'heading_p95': 0.009, 'coverage': 0.9}
    assert exceeded_limits(report, kept) == []


@pytest.mark.parametrize(
    ('name', 'limit', 'words'),
    [
        ('position_median', 0.0029, 'more'),
        ('heading_rms', 0.008, 'more'),
        ('coverage', 0.95, 'less'),
    ],
)
def test_a_broken_limit_is_named(report, name, limit, words):
    (line,) = exceeded_limits(report, {name: limit, 'position_max': 1.0})
    assert line.startswith(f'{name} is ')
    assert f'{words} than the limit {limit}' in line
