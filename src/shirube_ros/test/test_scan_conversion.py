"""Laser scans become rays as REP 117 says."""

import math

import numpy as np
import pytest
from sensor_msgs.msg import LaserScan

from shirube_ros.errors import ScanError
from shirube_ros.message_conversion import rays_from_scan


def scan(ranges: list[float], **changes: float) -> LaserScan:
    given = {'angle_min': -0.5, 'angle_increment': 0.25, 'range_min': 0.1, 'range_max': 8.0} | changes
    return LaserScan(ranges=ranges, **given)


def test_each_kind_of_range_has_its_meaning() -> None:
    ends, is_hit = rays_from_scan(scan([2.0, math.inf, -math.inf, math.nan, 0.0, 9.0]), 'scan')
    lengths = np.hypot(*ends[:, :2].T)
    np.testing.assert_allclose(lengths, [2.0, 8.0, 0.1, np.nan, np.nan, np.nan], rtol=1e-5)
    assert is_hit.tolist() == [True, False, True, False, False, False]
    np.testing.assert_allclose(np.arctan2(ends[:2, 1], ends[:2, 0]), [-0.5, -0.25], rtol=1e-5)


@pytest.mark.parametrize(
    'changes', [{'angle_increment': 0.0}, {'range_max': math.nan}, {'range_min': 9.0}, {'angle_min': math.inf}]
)
def test_limits_that_contradict_each_other_are_refused(changes: dict[str, float]) -> None:
    with pytest.raises(ScanError, match='check its publisher'):
        rays_from_scan(scan([1.0], **changes), 'scan')
