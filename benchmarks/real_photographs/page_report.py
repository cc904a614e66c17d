"""What became of the pages, as markdown."""

from __future__ import annotations

from collections import Counter

import numpy as np
from card_outlines import MEASURED_EVERY
from markdown_table import table
from numpy.typing import NDArray
from page_identification import transform_points
from page_trials import PageTrial
from page_truth import Photograph, framed_page, visible_pages

Array = NDArray[np.float64]

OUTCOMES = ('right', 'off', 'none', 'wrong')
COUNT_HEADS = ('page', 'images with its dots', 'visible', 'of these found', 'found', *OUTCOMES)
ERROR_HEADS = ('error mm: median', '95 %', 'max', 'to the dots mm: median', 'max', 'heading °: median', 'max')
FRAME_HEADS = (
    'frame of page',
    'images',
    'corners on the page by its dots, median mm',
    'spread of a corner, rms mm',
)


def page_report(
    name: str, photographs: list[Photograph], trials: list[PageTrial], *, is_printed: bool
) -> str:
    """Return how many frames were found, what the localizer made of them, and how far it is from the frames."""
    visible = {
        (photo.number, page) for photo in photographs for page in visible_pages(photo, is_printed=is_printed)
    }
    judged = [trial for trial in trials if is_printed or trial.number % MEASURED_EVERY != 0]
    groups = {
        'visible': [trial for trial in judged if (trial.number, trial.page) in visible],
        'a corner covered': [
            trial for trial in judged if trial.page is not None and (trial.number, trial.page) not in visible
        ],
    }
    errors = table(
        ('frames', 'views', *OUTCOMES, *ERROR_HEADS),
        [[group, *_counts_and_errors(members)] for group, members in groups.items() if members],
    )
    parts = [f'### {name}\n', _counts(photographs, trials, visible), _summary(photographs, trials, visible)]
    return '\n'.join([*parts, errors, _failures(trials), _frames(photographs)])


def _counts(photographs: list[Photograph], trials: list[PageTrial], visible: set[tuple[int, int]]) -> str:
    seen = Counter(page for photo in photographs for page in photo.pages)
    rows = []
    for page in sorted(seen):
        own = [trial for trial in trials if trial.page == page]
        wanted = {number for number, other in visible if other == page}
        outcomes = Counter(trial.outcome for trial in own)
        left_out = sum(trial.without_it == 'none' for trial in own)
        found = len(wanted & {trial.number for trial in own}), len(own)
        counts = [outcomes[outcome] for outcome in OUTCOMES]
        rows.append([page, seen[page], len(wanted), *found, *counts, f'{left_out} of {len(own)}'])
    return table((*COUNT_HEADS, 'no pose with the page left out'), rows)


def _summary(photographs: list[Photograph], trials: list[PageTrial], visible: set[tuple[int, int]]) -> str:
    missed = sorted(visible - {(trial.number, trial.page) for trial in trials if trial.page is not None})
    false = Counter(trial.outcome for trial in trials if trial.page is None)
    disagreements = 0
    for photo in photographs:
        for frame, identity in zip(photo.frames, photo.identities, strict=True):
            truth = framed_page(photo, frame)
            disagreements += truth is not None and identity is not None and identity.page != truth[0]
    return (
        f'Visible pages whose frame was found: {len(visible) - len(missed)} of {len(visible)}'
        f' (missed: {missed or "none"}). Frames found where there is none: {false.total()},'
        f' poses from them: {false["wrong"]}. The brute-force oracle names another page in {disagreements} frames.\n'
    )


def _counts_and_errors(trials: list[PageTrial]) -> list[object]:
    outcomes = Counter(trial.outcome for trial in trials)
    counts = [len(trials), *[outcomes[outcome] for outcome in OUTCOMES]]
    same_page = [trial for trial in trials if trial.outcome in {'right', 'off'}]
    if not same_page:
        return [*counts, *['–'] * len(ERROR_HEADS)]
    error = 1e3 * np.array([trial.error for trial in same_page])
    to_dots = 1e3 * np.array([trial.error_from_dots for trial in same_page])
    turn = np.abs(np.degrees([trial.turn for trial in same_page]))
    numbers = [*np.percentile(error, [50, 95, 100]), *np.percentile(to_dots, [50, 100])]
    return [*counts, *[f'{number:.2f}' for number in (*numbers, *np.percentile(turn, [50, 100]))]]


def _failures(trials: list[PageTrial]) -> str:
    return ''.join(
        f'- image {trial.number}, page {trial.page}: {trial.outcome}, {1e3 * trial.error:.2f} mm {trial.reason}\n'
        for trial in trials
        if trial.outcome != 'right'
    )


def _frames(photographs: list[Photograph]) -> str:
    """Return the frames' corners on the pages, measured with the dots."""
    corners: dict[int, list[Array]] = {}
    for photo in photographs:
        for frame in photo.frames:
            truth = framed_page(photo, frame)
            if truth is not None:
                inverse = np.linalg.inv(photo.pages[truth[0]].homography)
                corners.setdefault(truth[0], []).append(transform_points(inverse, truth[1]))
    rows = []
    for page, found in sorted(corners.items()):
        middle = np.median(found, axis=0)
        spread = np.sqrt(np.mean(np.sum((np.array(found) - middle) ** 2, axis=2)))
        places = ', '.join(f'({1e3 * x:.1f}, {1e3 * y:.1f})' for x, y in middle)
        rows.append([page, len(found), places, f'{1e3 * spread:.2f}' if len(found) > 1 else '–'])
    return table(FRAME_HEADS, rows)
