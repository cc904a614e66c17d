"""Detection of truncated JPEG and PNG data.

OpenCV decodes truncated data and fills the rest with grey, so the end marker is checked.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_END_MARKERS = {b'\xff\xd8': b'\xff\xd9', b'\x89P': b'IEND'}
"""End marker by the first bytes, for JPEG and PNG."""
_SEARCHED_BYTES = 1024
"""Number of last bytes that are searched, since cameras pad the end of JPEG data [byte]."""


def is_jpeg_or_png(data: NDArray[np.uint8]) -> bool:
    """Return whether data, shape (n,), is JPEG or PNG, by its first bytes."""
    return data[:2].tobytes() in _END_MARKERS


def is_truncated(data: NDArray[np.uint8]) -> bool:
    """Return whether a JPEG or PNG, shape (n,), lacks its end marker; False for other formats."""
    end = _END_MARKERS.get(data[:2].tobytes())
    return end is not None and end not in data[-_SEARCHED_BYTES:].tobytes()
