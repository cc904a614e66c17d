"""Whether an encoded image is there to its end.

OpenCV decodes what there is of a file that was cut off and fills up with grey, so the end is looked for.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_ENDS = {b'\xff\xd8': b'\xff\xd9', b'\x89P': b'IEND'}
"""First and last bytes of JPEG and PNG."""
_TAIL = 1024
"""Cameras pad the end of their JPEG files [byte]."""


def is_jpeg_or_png(data: NDArray[np.uint8]) -> bool:
    """Tell by the first bytes, shape (n,), whether data is of one of the kinds whose end is known."""
    return data[:2].tobytes() in _ENDS


def is_cut_off(data: NDArray[np.uint8]) -> bool:
    """Tell whether a JPEG or PNG, shape (n,), lacks its end; of other kinds nothing is known."""
    end = _ENDS.get(data[:2].tobytes())
    return end is not None and end not in data[-_TAIL:].tobytes()
