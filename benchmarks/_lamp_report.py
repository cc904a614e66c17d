"""Errors under lamps as cells of tables."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def format_centimetres(errors: list[float] | NDArray[np.float64]) -> str:
    """Return median / 95 % / max of errors [m]."""
    if len(errors) == 0:
        return '–'
    return ' / '.join(f'{100.0 * value:.2f}' for value in np.percentile(errors, [50.0, 95.0, 100.0]))


def format_number(value: float) -> str:
    """Return a number, a dash for NaN."""
    return '–' if math.isnan(value) else f'{value:.3f}'
