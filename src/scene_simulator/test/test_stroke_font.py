"""Letters form a row, each in its box."""

from __future__ import annotations

import itertools

import numpy as np

from scene_simulator.stroke_font import ADVANCE, text_strokes

LETTERS = '0123456789ABCDEFGHIKLMNOPRSTUVWXY'


def test_every_letter_is_in_its_box_and_two_pairs_are_twins() -> None:
    drawn = {letter: list(text_strokes(letter)) for letter in LETTERS}
    for strokes in drawn.values():
        points = np.concatenate(strokes)
        assert points.min() >= 0.0
        assert points[:, 0].max() <= 0.6
        assert points[:, 1].max() == 1.0
        assert all(len(stroke) > 1 for stroke in strokes)
        assert all((np.abs(np.diff(stroke, axis=0)).max(axis=1) > 0.0).all() for stroke in strokes)
    twins = [
        pair for pair in itertools.combinations(LETTERS, 2) if str(drawn[pair[0]]) == str(drawn[pair[1]])
    ]
    assert twins == [('0', 'O'), ('5', 'S')]


def test_letters_advance_and_a_blank_stays_blank() -> None:
    (first,), (second,) = list(text_strokes('L')), list(text_strokes(' L'))
    np.testing.assert_allclose(second - first, [(ADVANCE, 0.0)] * 3)
