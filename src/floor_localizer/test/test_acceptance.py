"""The bound on chance alignments: its properties, and its validity on random floors."""

import math

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.special import comb

from floor_localizer.core.constellation.acceptance import log_chance_alignments

RESIDUALS = np.array([1e-4, 2e-4, 5e-5, math.inf, 1.5e-4, 3e-4, math.inf, 8e-5])


def log_chance(residuals=RESIDUALS, smallest=2e-5, distance=0.1, dots=9e4, density=5384.0, scale=0.05):
    return log_chance_alignments(np.asarray(residuals), smallest, distance, dots, density, scale)


def plain_log_chance(residuals, smallest, distance, dots, density, scale):
    """The formula of the bound, evaluated for each k."""
    ordered = np.sort(residuals[np.isfinite(residuals)])
    n, expected = len(residuals), []
    for k in range(3, len(ordered) + 1):
        r = max(ordered[k - 1], smallest)
        pairs = density * 2.0 * math.pi * distance * (2.0 * scale * distance + 4.0 * r)
        tests = dots * pairs * (n - 2) * comb(n, k) * comb(k, 2)
        expected.append(tests * (density * math.pi * r * r) ** (k - 2))
    return math.log(min(expected))


def test_bound_is_the_written_formula_for_any_order_of_the_dots():
    assert log_chance() == pytest.approx(plain_log_chance(RESIDUALS, 2e-5, 0.1, 9e4, 5384.0, 0.05))
    assert log_chance(dots=9e5) - log_chance() == pytest.approx(math.log(10.0))
    shuffled = np.random.default_rng(0).permutation(RESIDUALS)
    assert log_chance(shuffled) == pytest.approx(log_chance())


def test_fewer_than_three_matches_are_no_evidence():
    for residuals in ([], [1e-5], [1e-5, 1e-5], [1e-5, 1e-5, math.inf, math.inf]):
        assert log_chance(np.array(residuals, dtype=np.float64)) == math.inf


@pytest.mark.parametrize(('argument', 'start'), [
    ('density', 3000.0), ('dots', 1e4), ('distance', 0.05), ('scale', 0.01), ('smallest', 1e-4),
    ('residuals', RESIDUALS),
])  # fmt: skip
def test_more_room_for_chance_or_larger_residuals_are_less_evidence(argument, start):
    values = [log_chance(**{argument: start * factor}) for factor in (1.0, 1.5, 2.0, 4.0)]
    assert values == sorted(values)
    assert values[0] < values[-1]


def test_one_more_match_is_more_and_one_more_miss_is_less_evidence():
    assert log_chance(np.append(RESIDUALS, 1e-4)) < log_chance()
    assert log_chance(np.append(RESIDUALS, math.inf)) > log_chance()


def test_residuals_below_the_accuracy_are_no_better_than_it():
    tiny = np.full(6, 1e-9)
    assert log_chance(tiny, smallest=1e-4) == pytest.approx(log_chance(np.full(6, 1e-4), smallest=1e-4))


def least_log_chance(rng, dots=60, seen=10, density=5384.0, scale=0.02):
    """The best pose of a random view on a random floor: every pair matched to every pair."""
    side = math.sqrt(dots / density)
    floor = rng.uniform(0.0, side, (dots, 2)) @ (1.0, 1j)
    view = rng.uniform(0.0, math.sqrt(seen / density), (seen, 2)) @ (1.0, 1j)
    tree = cKDTree(np.column_stack([floor.real, floor.imag]))
    starts, ends = np.nonzero(~np.eye(dots, dtype=bool))
    arms = floor[ends] - floor[starts]
    reach = 0.1 / math.sqrt(density)
    best = math.inf
    for i in range(seen):
        for j in range(i):
            a = arms / (view[j] - view[i])
            fits = np.abs(np.abs(a) - 1.0) <= scale
            places = a[fits, None] * (view - view[i]) + floor[starts[fits], None]
            residuals, _ = tree.query(
                np.stack([places.real, places.imag], axis=-1), distance_upper_bound=reach
            )
            for row in residuals[np.isfinite(residuals).sum(axis=1) >= 4]:
                matched = view[np.isfinite(row)]
                widest = np.max(np.abs(matched[:, None] - matched))
                best = min(best, log_chance_alignments(row, 1e-5, widest, float(dots), density, scale))
    return best


@pytest.mark.newest_set_only
def test_floors_of_chance_seldom_look_like_a_match():
    rng = np.random.default_rng(7)
    best = np.exp([least_log_chance(rng) for _ in range(150)])
    # P(min E < e) <= e by Markov's inequality: almost none in 150 floors.
    assert np.sum(best < 0.01) <= 5
    assert np.mean(best < 0.1) <= 0.2
