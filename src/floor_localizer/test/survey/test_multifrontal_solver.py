import numpy as np
import pytest

from floor_localizer.core.independent_tasks import InProcessRunner
from floor_localizer.core.survey.adjustment.multifrontal_solver import (
    MultifrontalSolver,
    NormalEquations,
    unknown_indices,
)
from floor_localizer.core.survey.array_store import MemoryArrayStore


def parts_of(count: int, images: int, rng: np.random.Generator) -> list[NormalEquations]:
    """Each part contains images near its number; one contains two distant images, one contains none."""
    parts = []
    for number in range(count):
        own = np.unique(np.clip(number * images // count + np.arange(-3, 15), 0, images - 1))
        if number == 4:
            own = np.array([2, images - 2])
        if number == 5:
            own = own[:0]
        rows = rng.normal(size=(6 * len(own) + 9, 6 * len(own)))
        parts.append(NormalEquations(own, rows.T @ rows, rng.normal(size=6 * len(own))))
    return parts


@pytest.mark.parametrize('count', [1, 7, 16, 27])
def test_the_solution_is_that_of_the_sum_of_all_parts(count):
    images, rng = 15 * count, np.random.default_rng(count)
    parts = parts_of(count, images, rng)
    A, g = np.zeros((6 * images, 6 * images)), np.zeros(6 * images)
    first, last = np.full(images, count), np.full(images, -1)
    for number, part in enumerate(parts):
        rows = unknown_indices(part.images)
        A[np.ix_(rows, rows)] += part.normal
        g[rows] += part.gradient
        first[part.images] = np.minimum(first[part.images], number)
        last[part.images] = number
    seen = unknown_indices(np.flatnonzero(last >= 0))
    expected = np.zeros(6 * images)
    expected[seen] = np.linalg.solve(A[np.ix_(seen, seen)], g[seen])
    solver = MultifrontalSolver(images, count, MemoryArrayStore(), InProcessRunner())
    solver.set_spans(np.column_stack([first, last]))
    found = solver.solve(parts.__getitem__)
    np.testing.assert_allclose(found.ravel(), expected, atol=1e-9 * np.abs(expected).max())
