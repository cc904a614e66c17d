"""Errors of displacements, what they are compared with, and the tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import SE2
from stereo_landmark.core.place.place_locator import PlaceFix

OURS = 'shirube'
WITHIN_95 = 7.815
"""The sum of three squared normal deviates is less in 95 %."""
PLANAR = np.ix_([0, 1, 3], [0, 1, 3])

Judged = tuple[NDArray[np.float64], NDArray[np.float64]]
"""An error, shape (3,), and a covariance that it is held against, shape (3, 3)."""


@dataclass
class Result:
    """Of one distance.

    Attributes:
        views: how often each method was asked.
        errors: found less true x, y [m] and yaw [rad], by method.
        bounded: shirube's errors with the bound of Cramer and Rao.
        stated: the same with the stated covariances.
        fitted: errors of the fit alone, with its covariances, which are the bound for its points.
        used: how many points each fix was made of.
        points: how many each lesson has.
        misses: why there was no fix.
        untaught: lessons in which less than four fields could be measured.
    """

    views: dict[str, int] = field(default_factory=dict)
    errors: dict[str, list[NDArray[np.float64]]] = field(default_factory=dict)
    bounded: list[Judged] = field(default_factory=list)
    stated: list[Judged] = field(default_factory=list)
    fitted: list[Judged] = field(default_factory=list)
    used: list[int] = field(default_factory=list)
    points: list[int] = field(default_factory=list)
    misses: list[str] = field(default_factory=list)
    untaught: int = 0

    def add(self, method: str, found: SE2 | None, truth: SE2) -> None:
        """Add an answer."""
        self.views[method] = self.views.get(method, 0) + 1
        errors = self.errors.setdefault(method, [])
        if found is not None:
            errors.append(error_of(found, truth))

    def compare(self, fix: PlaceFix, truth: SE2, bound: NDArray[np.float64], fitted: Judged | None) -> None:
        """Add what one of shirube's fixes is held against: the bound, shape (4, 4), and the fit alone."""
        error = error_of(fix.T_place_base, truth)
        self.bounded.append((error, bound[PLANAR]))
        self.stated.append((error, fix.covariance[PLANAR]))
        self.used.append(len(fix.names))
        if fitted is not None:
            self.fitted.append(fitted)


def error_of(found: SE2, truth: SE2) -> NDArray[np.float64]:
    """Return found less true x, y [m] and yaw [rad], shape (3,)."""
    return np.array([found.x - truth.x, found.y - truth.y, truth.yaw_to(found)])


def rms_ratios(judged: Sequence[Judged]) -> tuple[float, float]:
    """Return the root mean squares of position and of heading error, each over that of the covariances."""
    errors = np.array([error for error, _ in judged])
    variances = np.array([np.diag(covariance) for _, covariance in judged])
    squares, expected = (errors**2).mean(axis=0), variances.mean(axis=0)
    return float(np.sqrt(squares[:2].sum() / expected[:2].sum())), float(np.sqrt(squares[2] / expected[2]))


def consistency(judged: Sequence[Judged]) -> tuple[float, float]:
    """Return the mean squared error in standard deviations per coordinate, and the share in the 95 % ellipsoid."""
    distances = np.array([error @ np.linalg.solve(covariance, error) for error, covariance in judged])
    return float(distances.mean()) / 3.0, float(np.mean(distances <= WITHIN_95))


def print_results(results: dict[float, Result]) -> None:
    """Print the tables."""
    _print_errors(results)
    heads = (
        *(
            'distance',
            'points taught / used, mean',
            'rms position mm',
            'bound mm',
            'rms / bound',
            'rms heading deg',
        ),
        *('bound deg', 'rms / bound', 'fit alone: rms / bound, position, heading'),
        *('rms / stated, position, heading', 'NEES per coordinate', 'within 95 % ellipsoid'),
    )
    print('', _row(heads), '|---' * len(heads) + '|', sep='\n')
    for distance, result in results.items():
        print(_row(_cells_of_bound(distance, result)))
    print(f'\nLessons without four fields: {sum(result.untaught for result in results.values())}. No pose:')
    for result in results.values():
        for miss in result.misses:
            print(f'- {miss}')


def _print_errors(results: dict[float, Result]) -> None:
    heads = (
        'distance',
        'method',
        'found',
        'position mm: median / 95 % / max',
        'heading deg: median / 95 % / max',
    )
    print(_row(heads), '|---' * len(heads) + '|', sep='\n')
    for distance, result in results.items():
        for method, errors in result.errors.items():
            cells = [f'{distance:g} m', method, f'{len(errors)}/{result.views[method]}', '-', '-']
            if errors:
                x, y, yaw = np.array(errors).T
                cells[3] = _quantiles(1e3 * np.hypot(x, y), 2)
                cells[4] = _quantiles(np.degrees(np.abs(yaw)), 4)
            print(_row(cells))


def _cells_of_bound(distance: float, result: Result) -> list[str]:
    if not result.bounded:
        return [f'{distance:g} m', *['-'] * 11]
    errors = np.array([error for error, _ in result.bounded])
    bounds = np.array([np.diag(bound) for _, bound in result.bounded]).mean(axis=0)
    rms, ratios = np.sqrt((errors**2).mean(axis=0)), rms_ratios(result.bounded)
    alone, stated, (nees, share) = (
        rms_ratios(result.fitted),
        rms_ratios(result.stated),
        consistency(result.stated),
    )
    return [
        *(f'{distance:g} m', f'{np.mean(result.points):.1f} / {np.mean(result.used):.1f}'),
        *(f'{1e3 * np.hypot(*rms[:2]):.2f}', f'{1e3 * np.sqrt(bounds[:2].sum()):.2f}', f'{ratios[0]:.2f}'),
        *(f'{np.degrees(rms[2]):.4f}', f'{np.degrees(np.sqrt(bounds[2])):.4f}', f'{ratios[1]:.2f}'),
        *(f'{alone[0]:.2f}, {alone[1]:.2f}', f'{stated[0]:.2f}, {stated[1]:.2f}'),
        *(f'{nees:.2f}', f'{100.0 * share:.0f} %'),
    ]


def _quantiles(values: NDArray[np.float64], digits: int) -> str:
    return ' / '.join(f'{value:.{digits}f}' for value in np.quantile(values, (0.5, 0.95, 1.0)))


def _row(cells: Sequence[str]) -> str:
    return f'| {" | ".join(cells)} |'
