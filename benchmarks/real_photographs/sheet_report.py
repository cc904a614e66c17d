"""What became of the sheets, as markdown."""

from __future__ import annotations

from collections import Counter

import numpy as np
from card_outlines import MEASURED_EVERY
from markdown_table import table
from numpy.typing import NDArray
from sheet_oracle import transformed
from sheet_trials import SheetTrial
from sheet_truth import Photograph, framed_sheet, visible_sheets

Array = NDArray[np.float64]

OUTCOMES = ('right', 'off', 'none', 'wrong')
COUNT_HEADS = ('sheet', 'images with its dots', 'visible', 'of these found', 'found', *OUTCOMES)
ERROR_HEADS = ('error mm: median', '95 %', 'max', 'to the dots mm: median', 'max', 'heading °: median', 'max')
FRAME_HEADS = (
    'frame of sheet',
    'images',
    'corners on the sheet by its dots, median mm',
    'spread of a corner, rms mm',
)


def sheet_report(
    name: str, photographs: list[Photograph], trials: list[SheetTrial], *, is_printed: bool
) -> str:
    """Return how many frames were found, what the localizer made of them, and how far it is from the frames."""
    visible = {
        (photo.number, sheet)
        for photo in photographs
        for sheet in visible_sheets(photo, is_printed=is_printed)
    }
    judged = [trial for trial in trials if is_printed or trial.number % MEASURED_EVERY != 0]
    groups = {
        'visible': [trial for trial in judged if (trial.number, trial.sheet) in visible],
        'a corner covered': [
            trial
            for trial in judged
            if trial.sheet is not None and (trial.number, trial.sheet) not in visible
        ],
    }
    errors = table(
        ('frames', 'views', *OUTCOMES, *ERROR_HEADS),
        [[group, *_counts_and_errors(members)] for group, members in groups.items() if members],
    )
    parts = [f'### {name}\n', _counts(photographs, trials, visible), _summary(photographs, trials, visible)]
    return '\n'.join([*parts, errors, _failures(trials), _frames(photographs)])


def _counts(photographs: list[Photograph], trials: list[SheetTrial], visible: set[tuple[int, int]]) -> str:
    seen = Counter(sheet for photo in photographs for sheet in photo.sheets)
    rows = []
    for sheet in sorted(seen):
        own = [trial for trial in trials if trial.sheet == sheet]
        wanted = {number for number, other in visible if other == sheet}
        outcomes = Counter(trial.outcome for trial in own)
        left_out = sum(trial.without_it == 'none' for trial in own)
        found = len(wanted & {trial.number for trial in own}), len(own)
        counts = [outcomes[outcome] for outcome in OUTCOMES]
        rows.append([sheet, seen[sheet], len(wanted), *found, *counts, f'{left_out} of {len(own)}'])
    return table((*COUNT_HEADS, 'no pose with the sheet left out'), rows)


def _summary(photographs: list[Photograph], trials: list[SheetTrial], visible: set[tuple[int, int]]) -> str:
    missed = sorted(visible - {(trial.number, trial.sheet) for trial in trials if trial.sheet is not None})
    false = Counter(trial.outcome for trial in trials if trial.sheet is None)
    disagreements = 0
    for photo in photographs:
        for frame, identity in zip(photo.frames, photo.identities, strict=True):
            truth = framed_sheet(photo, frame)
            disagreements += truth is not None and identity is not None and identity.sheet != truth[0]
    return (
        f'Visible sheets whose frame was found: {len(visible) - len(missed)} of {len(visible)}'
        f' (missed: {missed or "none"}). Frames found where there is none: {false.total()},'
        f' poses from them: {false["wrong"]}. The brute-force oracle names another sheet in {disagreements} frames.\n'
    )


def _counts_and_errors(trials: list[SheetTrial]) -> list[object]:
    outcomes = Counter(trial.outcome for trial in trials)
    counts = [len(trials), *[outcomes[outcome] for outcome in OUTCOMES]]
    same_sheet = [trial for trial in trials if trial.outcome in {'right', 'off'}]
    if not same_sheet:
        return [*counts, *['–'] * len(ERROR_HEADS)]
    error = 1e3 * np.array([trial.error for trial in same_sheet])
    to_dots = 1e3 * np.array([trial.error_from_dots for trial in same_sheet])
    turn = np.abs(np.degrees([trial.turn for trial in same_sheet]))
    numbers = [*np.percentile(error, [50, 95, 100]), *np.percentile(to_dots, [50, 100])]
    return [*counts, *[f'{number:.2f}' for number in (*numbers, *np.percentile(turn, [50, 100]))]]


def _failures(trials: list[SheetTrial]) -> str:
    return ''.join(
        f'- image {trial.number}, sheet {trial.sheet}: {trial.outcome}, {1e3 * trial.error:.2f} mm {trial.reason}\n'
        for trial in trials
        if trial.outcome != 'right'
    )


def _frames(photographs: list[Photograph]) -> str:
    """Return the frames' corners on the sheets, measured with the dots."""
    corners: dict[int, list[Array]] = {}
    for photo in photographs:
        for frame in photo.frames:
            truth = framed_sheet(photo, frame)
            if truth is not None:
                inverse = np.linalg.inv(photo.sheets[truth[0]].homography)
                corners.setdefault(truth[0], []).append(transformed(inverse, truth[1]))
    rows = []
    for sheet, found in sorted(corners.items()):
        middle = np.median(found, axis=0)
        spread = np.sqrt(np.mean(np.sum((np.array(found) - middle) ** 2, axis=2)))
        places = ', '.join(f'({1e3 * x:.1f}, {1e3 * y:.1f})' for x, y in middle)
        rows.append([sheet, len(found), places, f'{1e3 * spread:.2f}' if len(found) > 1 else '–'])
    return table(FRAME_HEADS, rows)
