"""What became of the terrazzo, as markdown."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import numpy as np
from markdown_table import table
from terrazzo_chips import COLOURS, DIAMETERS, dots_of_chips, segment_chips
from terrazzo_trials import TerrazzoTrial
from terrazzo_views import SCALE, Image

from floor_localizer.core.dot_extraction.detector import DotDetector

VIEW_HEADS = (
    *('polarity', 'views', 'right', 'none', 'wrong', 'error mm: median', '95 %', 'max'),
    *('heading °: median', 'max', 'dots: median', 'match rate: median', 'least'),
)


def chip_report(picture: Image, detector: DotDetector) -> str:
    """Return which chips of the whole picture the detector finds, by colour and size."""
    chips = segment_chips(picture)
    pixels = detector.detect(picture).pixels
    single = dots_of_chips(chips, pixels) == 1
    limits = list(pairwise(DIAMETERS))
    rows = []
    for colour, name in enumerate(COLOURS):
        cells = []
        for low, high in limits:
            matched = (chips.colours == colour) & (chips.diameters >= low) & (chips.diameters < high)
            matched &= ~chips.at_border
            cells.append(f'{(single & matched).sum()} of {matched.sum()}')
        rows.append([name, *cells])
    heads = [f'{low:g} to {high:g} px' for low, high in limits]
    return (
        f'The picture is taken as {1e3 * SCALE * picture.shape[1]:.0f} mm wide ({1e3 * SCALE:.3f} mm/px). '
        f'The detector finds {len(pixels)} dots on it. Chips with exactly one dot on them, of all chips that a '
        f'plain threshold shows:\n\n{table(["chips", *heads], rows)}'
    )


def view_report(trials_of: dict[str, list[TerrazzoTrial]]) -> str:
    """Return how views cut from the picture were located, by the detector's polarity."""
    return table(VIEW_HEADS, [[polarity, *_row(trials)] for polarity, trials in trials_of.items()])


def _row(trials: list[TerrazzoTrial]) -> list[object]:
    outcomes = Counter(trial.outcome for trial in trials)
    counts = [len(trials), outcomes['right'], outcomes['none'], outcomes['wrong']]
    located = [trial for trial in trials if trial.outcome != 'none']
    dots = f'{np.median([trial.dots for trial in trials]):.0f}'
    if not located:
        return [*counts, *['–'] * 5, dots, '–', '–']
    error = 1e3 * np.array([trial.error for trial in located])
    turn = np.abs(np.degrees([trial.turn for trial in located]))
    rate = np.array([trial.match_rate for trial in located])
    numbers = [*np.percentile(error, [50, 95, 100]), *np.percentile(turn, [50, 100])]
    return [*counts, *[f'{x:.3f}' for x in numbers], dots, f'{np.median(rate):.2f}', f'{rate.min():.2f}']
