"""A packed constellation: unpacking returns what was packed."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from floor_localizer.core.constellation.dot_grid import build_dot_grid
from floor_localizer.core.constellation.index_format import (
    DOTS_MAX,
    LENGTH_ROUNDING,
    first_dot_of_entry,
    length_of_entry,
    pack_baseline,
    pack_entry,
    second_dot_of_entry,
    subcell_of_entry,
)

LONGEST = 0.04
UNHURRIED = settings(deadline=None)


def entry_of(subcell, first, dx, dy):
    return np.uint64(pack_entry(np.uint64(subcell), np.uint64(pack_baseline(dx, dy, LONGEST)), first))


@UNHURRIED
@given(
    st.integers(0, 2**24 - 1),
    st.integers(0, DOTS_MAX - 1),
    st.floats(-math.pi, math.pi),
    st.floats(LONGEST / 8.0 * 1.001, LONGEST),
)
def test_unpacking_returns_what_was_packed(subcell, first, angle, length):
    entry = entry_of(subcell, first, length * math.cos(angle), length * math.sin(angle))
    assert subcell_of_entry(entry) == subcell
    assert first_dot_of_entry(entry) == first
    # Lengths are quantized on a logarithmic scale.
    assert abs(math.log(length_of_entry(entry, LONGEST) / length)) <= LENGTH_ROUNDING * 1.001


@pytest.mark.parametrize('angle', np.linspace(-math.pi, math.pi, 37).tolist())
@pytest.mark.parametrize('length', [0.006, 0.02, 0.0399])
def test_the_other_end_of_a_baseline_is_found(angle, length):
    # Far from the origin, where single precision is coarser.
    dots = np.array([[100.0, 50.0], [100.0 + length * math.cos(angle), 50.0 + length * math.sin(angle)]])
    grid, order = build_dot_grid(dots)
    first, second = np.argsort(order)
    entry = entry_of(5, first, *(dots[1] - dots[0]))
    assert second_dot_of_entry(grid, entry, first, LONGEST) == second


def test_where_no_dot_is_there_is_no_other_end():
    grid, _ = build_dot_grid(np.array([[0.0, 0.0], [0.0, 0.03]]))
    assert second_dot_of_entry(grid, entry_of(0, 0, 0.03, 0.0), 0, LONGEST) == -1
