"""Thinning of a binary image in passes: the paper's control of edge extraction (3.3b, 4a)."""

import numpy as np
from numba import njit

from stereo_landmark.core.arrays import Masks


@njit(cache=True)
def thin(binary: Masks, passes: int) -> Masks:
    """Return a binary image thinned by at most so many passes, each of which peels one layer (Zhang & Suen 1984).

    Args:
        binary: mask of the pixels above the threshold, shape (h, w); its border is ignored.
        passes: number of passes; lines up to twice as wide become one pixel wide.
    """
    mask = binary.copy()
    mask[0], mask[-1], mask[:, 0], mask[:, -1] = False, False, False, False
    for _ in range(passes):
        removed = 0
        for side in range(2):
            peeled = np.zeros_like(mask)
            for y in range(1, mask.shape[0] - 1):
                for x in range(1, mask.shape[1] - 1):
                    peeled[y, x] = mask[y, x] and _is_removable(mask, x, y, side)
            mask &= ~peeled
            removed += int(np.sum(peeled))
        if removed == 0:
            break
    return mask


@njit(cache=True)
def _is_removable(mask: Masks, x: int, y: int, side: int) -> bool:
    """Return whether a pixel is at the lower right (side 0) or upper left edge of a line that stays connected."""
    up, right, down, left = mask[y - 1, x], mask[y, x + 1], mask[y + 1, x], mask[y, x - 1]
    around = (up, mask[y - 1, x + 1], right, mask[y + 1, x + 1], down, mask[y + 1, x - 1], left, mask[y - 1, x - 1])
    count, starts = 0, 0
    for k in range(8):
        count += around[k]
        starts += around[(k + 1) % 8] and not around[k]
    if not (2 <= count <= 6 and starts == 1):
        return False
    if side == 0:
        return not (up and right and down) and not (right and down and left)
    return not (up and right and left) and not (up and down and left)
