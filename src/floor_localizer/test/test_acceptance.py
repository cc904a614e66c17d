"""The expected number of chance alignments: its properties, and its truth on random floors."""

import math
from itertools import permutations

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.special import comb, factorial

from floor_localizer.core.constellation.acceptance import log_chance_alignments

RESIDUALS = np.array([1e-4, 2e-4, 5e-5, math.inf, 1.5e-4, 3e-4, math.inf, 8e-5])


def view_of(residuals):
    return np.random.default_rng(3).uniform(-0.05, 0.05, (2, len(residuals))).T @ (1.0, 1j)


def log_chance(residuals=RESIDUALS, smallest=2e-5, size=1.0, dots=9e4, density=5384.0, scale=0.05):
    z = size * view_of(residuals)
    return log_chance_alignments(np.asarray(residuals), z, smallest, dots, density, scale)


def plain_log_chance(residuals, z, smallest, dots, density, scale):
    """The formula, evaluated for each k."""
    order, n, expected = np.argsort(residuals), len(residuals), []
    for k in range(3, int(np.isfinite(residuals).sum()) + 1):
        closest = z[order[:k]]
        spread = np.sum(np.abs(closest - closest.mean()) ** 2)
        squares = max(np.sum(residuals[order[:k]] ** 2), (2 * k - 4) * smallest**2)
        similarities = dots * density * 4.0 * math.pi * scale * k * spread
        ball = (math.pi * density * squares) ** (k - 2) / factorial(k - 2)
        expected.append((n - 2) * comb(n, k) * similarities * ball)
    return math.log(min(expected))


def test_it_is_the_written_formula_for_any_order_of_the_dots():
    z = view_of(RESIDUALS)
    expected = plain_log_chance(RESIDUALS, z, 2e-5, 9e4, 5384.0, 0.05)
    assert log_chance() == pytest.approx(expected)
    assert log_chance(dots=9e5) - log_chance() == pytest.approx(math.log(10.0))
    shuffled = np.random.default_rng(0).permutation(len(z))
    assert log_chance_alignments(RESIDUALS[shuffled], z[shuffled] + 7.0, 2e-5, 9e4, 5384.0, 0.05) == pytest.approx(
        expected
    )


@pytest.mark.parametrize(('dots', 'seen'), [(60, 3), (24, 4)])
def test_random_floors_have_as_many_alignments_as_expected(dots, seen):
    """On a torus, where no view crosses the border of the floor, the count is a Poisson number of this mean."""
    rng, density, scale, squares = np.random.default_rng(4), 5384.0, 0.05, 8e-6 * (seen - 2) ** 2
    side = math.sqrt(dots / density)
    count = expected = 0.0
    tuples = np.array(list(permutations(range(dots), seen)))
    for _ in range(6):
        floor = rng.uniform(0.0, side, (dots, 2)) @ (1.0, 1j)
        z = rng.uniform(0.0, 0.5 * side, (seen, 2)) @ (1.0, 1j)
        shifts = floor[tuples] - floor[tuples[:, :1]]
        m = (shifts.real + 0.5 * side) % side + 1j * ((shifts.imag + 0.5 * side) % side)
        z, m = z - z.mean(), m - m.mean(axis=1, keepdims=True)
        spread = np.sum(np.abs(z) ** 2)
        a = m @ z.conj() / spread
        is_aligned = np.sum(np.abs(m - a[:, None] * z) ** 2, axis=1) < squares
        count += np.sum(is_aligned & (np.abs(np.abs(a) - 1.0) < scale))
        residuals = np.full(seen, math.sqrt(squares / seen))
        # Tuples of distinct dots, and n - 2 = 2 possible numbers of matches of four view dots.
        distinct = np.prod(1.0 - np.arange(seen) / dots) / (seen - 2)
        expected += distinct * math.exp(log_chance_alignments(residuals, z, 0.0, dots, density, scale))
    assert expected > 80
    assert abs(count - expected) < 4.0 * math.sqrt(expected)


def test_fewer_than_three_matches_are_no_evidence():
    for residuals in ([], [1e-5], [1e-5, 1e-5], [1e-5, 1e-5, math.inf, math.inf]):
        assert log_chance(np.array(residuals, dtype=np.float64)) == math.inf


@pytest.mark.parametrize(('argument', 'start'), [
    ('density', 3000.0), ('dots', 1e4), ('size', 0.5), ('scale', 0.01), ('smallest', 1e-4),
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
            residuals, _ = tree.query(np.stack([places.real, places.imag], axis=-1), distance_upper_bound=reach)
            for row in residuals[np.isfinite(residuals).sum(axis=1) >= 4]:
                best = min(best, log_chance_alignments(row, view, 1e-5, float(dots), density, scale))
    return best


@pytest.mark.newest_set_only
def test_floors_of_chance_seldom_look_like_a_match():
    rng = np.random.default_rng(7)
    best = np.exp([least_log_chance(rng) for _ in range(150)])
    # P(min E < e) <= e by Markov's inequality: almost none in 150 floors.
    assert np.sum(best < 0.01) <= 5
    assert np.mean(best < 0.1) <= 0.2
