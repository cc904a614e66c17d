"""Coverage: the fraction of images with a pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Coverage:
    """Number of stamps with a pose.

    Attributes:
        expected: number of stamps that should have a pose.
        covered: number of expected stamps with a pose.
        excluded: number of stamps within an excluded interval.
        missing_ns: array of int64, stamps without a pose [ns].
    """

    expected: int
    covered: int
    excluded: int
    missing_ns: NDArray[np.int64]

    @property
    def fraction(self) -> float:
        """Covered fraction of the expected stamps, 0 to 1; 1 if none is expected."""
        return self.covered / self.expected if self.expected else 1.0


def compute_coverage(
    expected_ns: NDArray[np.int64],
    estimated_ns: NDArray[np.int64],
    tolerance_ns: int,
    excluded_ns: NDArray[np.int64],
) -> Coverage:
    """Count the stamps that have a pose.

    Args:
        expected_ns: array of int64, shape (n,), stamps of the images [ns].
        estimated_ns: array of int64, shape (m,), increasing, m > 0, stamps of the poses [ns].
        tolerance_ns: largest difference between the stamps of a pose and its image [ns].
        excluded_ns: array of int64, shape (k, 2), start and end of each interval in which no pose is expected,
            both included [ns].
    """
    is_excluded = np.zeros(len(expected_ns), dtype=bool)
    for start, end in excluded_ns:
        is_excluded |= (start <= expected_ns) & (expected_ns <= end)
    expected = expected_ns[~is_excluded]
    right = np.minimum(np.searchsorted(estimated_ns, expected), len(estimated_ns) - 1)
    left = np.maximum(right - 1, 0)
    distance = np.minimum(np.abs(estimated_ns[right] - expected), np.abs(estimated_ns[left] - expected))
    covered = distance <= tolerance_ns
    return Coverage(len(expected), int(covered.sum()), int(is_excluded.sum()), expected[~covered])
