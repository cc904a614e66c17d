"""Accuracy of a trajectory against ground truth: errors, coverage, report and limits."""

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from shirube_bags.errors import TrajectoryError
from shirube_bags.stamps import NANOSECONDS, text_from_stamp
from shirube_bags.trajectory import Trajectory, can_interpolate, interpolate


@dataclass(frozen=True)
class TrajectoryErrors:
    """Errors of the n poses that have ground truth at their stamps.

    Attributes:
        estimate, reference: compared poses, and the ground truth at the same stamps.
        position: position errors, shape (n,) [m].
        heading: yaw errors about the robot's upward axis, shape (n,) [rad], in [-pi, pi], counter-clockwise positive.
        unmatched: number of estimated poses without ground truth.
    """

    estimate: Trajectory
    reference: Trajectory
    position: NDArray[np.float64]
    heading: NDArray[np.float64]
    unmatched: int


@dataclass(frozen=True)
class ErrorStatistics:
    """Statistics of absolute errors, in their unit: median, root mean square, 95 % quantile, maximum."""

    median: float
    rms: float
    p95: float
    max: float


def compare_trajectories(estimate: Trajectory, reference: Trajectory, longest_gap: float) -> TrajectoryErrors:
    """Compare an estimate with the reference, which is interpolated at its stamps over gaps up to
    ``longest_gap`` [s].

    There is no alignment: both are poses in the same map frame. A rigid motion of both changes no error.

    Raises:
        TrajectoryError: the two have no stamps in common.
    """
    known = can_interpolate(reference, estimate.stamps_ns, round(longest_gap * NANOSECONDS))
    if not known.any():
        raise TrajectoryError(
            f'the estimate ({time_span(estimate)}) and the reference ({time_span(reference)}) have no stamps '
            'in common; check that both are of the same drive and stamped with the time of the images'
        )
    compared = estimate.select(known)
    truth = interpolate(reference, compared.stamps_ns)
    position = np.linalg.norm(compared.positions - truth.positions, axis=1)
    rotation_error = Rotation.from_quat(truth.quaternions).inv() * Rotation.from_quat(compared.quaternions)
    heading = rotation_error.as_euler('xyz')[:, 2]
    return TrajectoryErrors(compared, truth, position, heading, int(len(estimate) - len(compared)))


def error_statistics(errors: NDArray[np.float64]) -> ErrorStatistics:
    """Return the statistics of errors, shape (n,) with n > 0."""
    sizes = np.abs(errors)
    median, p95 = np.quantile(sizes, (0.5, 0.95)).tolist()
    return ErrorStatistics(median, float(np.sqrt(np.mean(sizes**2))), p95, float(sizes.max()))


def time_span(trajectory: Trajectory) -> str:
    """Return the first and the last stamp as text, in seconds."""
    first, last = (int(stamp) / NANOSECONDS for stamp in trajectory.stamps_ns[[0, -1]])
    return f'{first:.3f} s to {last:.3f} s'


@dataclass(frozen=True)
class Coverage:
    """Numbers of stamps that should have a pose, that have one, that are excluded, and the stamps without one [ns]."""

    expected: int
    covered: int
    excluded: int
    missing_ns: NDArray[np.int64]

    @property
    def fraction(self) -> float:
        """Covered fraction of the expected stamps, 0 to 1; 1 if none is expected."""
        return self.covered / self.expected if self.expected else 1.0


def compute_coverage(
    expected_ns: NDArray[np.int64], estimated_ns: NDArray[np.int64], tolerance_ns: int, excluded_ns: NDArray[np.int64]
) -> Coverage:
    """Count the expected stamps [ns], shape (n,), with an estimate, shape (m,), increasing, m > 0, within a
    tolerance.

    ``excluded_ns``, shape (k, 2), has the first and last stamp of each interval in which no pose is expected.
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


STATISTICS = tuple(field.name for field in dataclasses.fields(ErrorStatistics))
COVERAGE = 'coverage'


@dataclass(frozen=True)
class AccuracyReport:
    """Accuracy of one run: poses with and without truth, statistics of position [m] and heading [rad], coverage."""

    compared: int
    unmatched: int
    position: ErrorStatistics
    heading: ErrorStatistics
    coverage: Coverage
    expected_from: str

    def metrics(self) -> dict[str, float]:
        """Return the metrics that can be limited: ``position_rms`` [m], …, ``heading_max`` [rad], ``coverage``."""
        return {
            **{f'position_{name}': value for name, value in dataclasses.asdict(self.position).items()},
            **{f'heading_{name}': value for name, value in dataclasses.asdict(self.heading).items()},
            COVERAGE: self.coverage.fraction,
        }


def make_report(errors: TrajectoryErrors, coverage: Coverage, expected_from: str) -> AccuracyReport:
    """Compute the report of a comparison."""
    position, heading = error_statistics(errors.position), error_statistics(errors.heading)
    return AccuracyReport(len(errors.estimate), errors.unmatched, position, heading, coverage, expected_from)


def format_report(report: AccuracyReport) -> str:
    """Format the report as a text table, in millimetres and degrees."""
    rows = [f'{"error":<16}' + ''.join(f'{name:>10}' for name in STATISTICS)]
    for name, unit, scale, statistics in (
        ('position', 'mm', 1000.0, report.position),
        ('heading', 'deg', math.degrees(1.0), report.heading),
    ):
        values = dataclasses.astuple(statistics)
        rows.append(f'{f"{name} [{unit}]":<16}' + ''.join(f'{value * scale:>10.3f}' for value in values))
    coverage = report.coverage
    rows.append(
        f'coverage {coverage.fraction:.2%}: {coverage.covered} of {coverage.expected} stamps of '
        f'{report.expected_from} have a pose, {coverage.excluded} excluded'
    )
    rows.append(f'{report.compared} poses compared, {report.unmatched} without ground truth')
    return '\n'.join(rows)


def report_to_dict(report: AccuracyReport) -> dict[str, Any]:
    """Return the report as JSON data, in metres and radians; stamps in seconds."""
    coverage = report.coverage
    return {
        'compared': report.compared,
        'unmatched': report.unmatched,
        'position': dataclasses.asdict(report.position),
        'heading': dataclasses.asdict(report.heading),
        COVERAGE: {
            'share': coverage.fraction,
            'expected': coverage.expected,
            'covered': coverage.covered,
            'excluded': coverage.excluded,
            'expected_from': report.expected_from,
            'missing': [float(text_from_stamp(stamp)) for stamp in coverage.missing_ns],
        },
    }


def exceeded_limits(report: AccuracyReport, limits: Mapping[str, float]) -> list[str]:
    """Return a message for each violated limit, by metric: a lower limit for the coverage, upper limits otherwise."""
    metrics = report.metrics()
    lines = []
    for name, limit in limits.items():
        value = metrics[name]
        too_low = name == COVERAGE
        if value < limit if too_low else value > limit:
            lines.append(f'{name} is {value:.6g}, {"less" if too_low else "more"} than the limit {limit:.6g}')
    return lines
