"""Conversion of LaserScan messages to rays, as REP 117 defines their ranges."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import LaserScan

from shirube_ros.errors import ScanError


class ScanRays(NamedTuple):
    """Ends of the rays in the frame of the scan, shape (n, 3) [m], NaN where unknown, and which of them hit."""

    ends: NDArray[np.float32]
    is_hit: NDArray[np.bool_]


def rays_from_scan(message: LaserScan, topic: str) -> ScanRays:
    """Return the rays of a scan.

    REP 117: -inf is too close to measure, an obstacle at range_min; +inf is nothing within range_max, free up to there;
    NaN is unknown. Finite ranges outside of the limits are unknown, too, as LaserScan defines them.

    Raises:
        ScanError: limits or angles that are not finite or contradict each other.
    """
    low, high, first, step = (
        float(value) for value in (message.range_min, message.range_max, message.angle_min, message.angle_increment)
    )
    if not all(map(math.isfinite, (low, high, first, step))) or step == 0.0:
        raise ScanError(f'{topic} has limits or angles that are not finite, or a step of 0; check its publisher')
    if not 0.0 <= low < high:
        raise ScanError(f'{topic} has a range_min that is not below range_max; check its publisher')
    ranges = np.array(message.ranges, dtype=np.float64)
    is_far, is_near = ranges == np.inf, ranges == -np.inf
    is_valid = (ranges >= low) & (ranges <= high)
    length = np.select([is_far, is_near, is_valid], [high, low, ranges], np.nan)
    angles = first + step * np.arange(len(ranges))
    ends = np.column_stack([length * np.cos(angles), length * np.sin(angles), 0.0 * length])
    return ScanRays(ends.astype(np.float32), is_near | is_valid)
