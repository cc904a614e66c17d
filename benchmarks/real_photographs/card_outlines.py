"""The frames of the pages: what the corners that are seen in an image are on the page itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PRINTED_FRAME = 0.04 * np.array([[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]])
"""The printed line round a page's dots: a square of ``marker_width`` (80 mm) about the page's centre [m]."""

CARD_OUTLINES: dict[int, Array] = {
    0: 1e-3 * np.array([[-43.04, 47.89], [43.43, 47.57], [41.87, -47.10], [-44.29, -47.08]]),
    1: 1e-3 * np.array([[-43.61, 47.30], [40.59, 46.60], [40.00, -47.31], [-47.18, -47.26]]),
    3: 1e-3 * np.array([[-44.41, 46.61], [43.01, 46.59], [42.49, -52.93], [-44.19, -52.43]]),
    7: 1e-3 * np.array([[-46.77, 48.46], [39.49, 48.49], [41.72, -47.81], [-47.47, -47.73]]),
}
"""The cards of the movie, which have no printed line: their corners, cut by hand, on the page [m].

Measured in every tenth frame of the movie, from the found corners and the homography of the page's dots, and taken
as the median. They lie clockwise from the upper left corner, x to the right and y up on the printed page.
"""

MEASURED_EVERY = 10
"""Frames of the movie whose numbers this divides were used to measure the cards; they are left out of trials."""

USUAL_CARD: Array = np.mean(list(CARD_OUTLINES.values()), axis=0)
"""A card whose outline is not known [m]."""


def frame_of(page: int | None, *, is_printed: bool) -> Array:
    """Return the corners of a page's frame on the page, shape (4, 2) [m]; of a usual one where it is not known."""
    if is_printed:
        return PRINTED_FRAME
    return USUAL_CARD if page is None else CARD_OUTLINES.get(page, USUAL_CARD)
