"""A plain alphabet of straight strokes, as on engraved plates."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

ADVANCE = 0.85
"""Distance from one letter to the next, the height is 1."""

# Strokes, separated by blanks, through grid points: 0 to 2 to the right and 0 to 4 up.
_GLYPHS = {
    '0': '0004242000',
    '1': '031410',
    '2': '042422020020',
    '3': '04242000 0222',
    '4': '040222 2420',
    '5': '240402222000',
    '6': '240400202202',
    '7': '042410',
    '8': '0004242000 0222',
    '9': '220204242000',
    'A': '0003142320 0222',
    'B': '0004142312211000 0212',
    'C': '24040020',
    'D': '000414232110 1000',
    'E': '24040020 0212',
    'F': '240400 0212',
    'G': '240400202212',
    'H': '0004 2420 0222',
    'I': '1014',
    'K': '0004 240220',
    'L': '040020',
    'M': '0004122420',
    'N': '00042024',
    'O': '0004242000',
    'P': '0004242202',
    'R': '0004242202 1220',
    'S': '240402222000',
    'T': '0424 1014',
    'U': '04002024',
    'V': '041024',
    'W': '0400122024',
    'X': '0024 0420',
    'Y': '041224 1210',
}


def text_strokes(text: str) -> Iterator[NDArray[np.float64]]:
    """Yield the strokes of a line of text, each of shape (n, 2); letters are 1 high and begin at the origin.

    Unknown characters are left blank.
    """
    for index, letter in enumerate(text):
        for stroke in _GLYPHS.get(letter, '').split():
            grid = np.array([int(digit) for digit in stroke], dtype=np.float64).reshape(-1, 2)
            yield grid * (0.3, 0.25) + (index * ADVANCE, 0.0)
