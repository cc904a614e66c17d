"""Accuracy of a run against ground truth, as text and as JSON, and its limits."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from shirube_bags.coverage import Coverage
from shirube_bags.stamps import text_from_stamp
from shirube_bags.trajectory_errors import ErrorStatistics, TrajectoryErrors, error_statistics

STATISTICS = tuple(field.name for field in dataclasses.fields(ErrorStatistics))
COVERAGE = 'coverage'


@dataclass(frozen=True)
class AccuracyReport:
    """Accuracy of one run.

    Attributes:
        compared: number of poses with ground truth at their stamp.
        unmatched: number of poses without.
        position: statistics of the position errors [m].
        heading: statistics of the heading errors [rad].
        coverage: stamps with and without a pose.
        expected_from: source of the expected stamps, for the text report.
    """

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
    return AccuracyReport(
        compared=len(errors.estimate),
        unmatched=errors.unmatched,
        position=error_statistics(errors.position),
        heading=error_statistics(errors.heading),
        coverage=coverage,
        expected_from=expected_from,
    )


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
    """Return a message for each limit that the report violates.

    Args:
        report: accuracy of the run.
        limits: limits by metric (`AccuracyReport.measures`); a lower limit for the coverage, else upper limits.
    """
    metrics = report.metrics()
    lines = []
    for name, limit in limits.items():
        value = metrics[name]
        too_low = name == COVERAGE
        if value < limit if too_low else value > limit:
            lines.append(f'{name} is {value:.6g}, {"less" if too_low else "more"} than the limit {limit:.6g}')
    return lines
