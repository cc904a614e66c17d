"""Types of arrays; their shapes and units are in the docstrings."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Float32s = NDArray[np.float32]
Ints = NDArray[np.int64]
Booleans = NDArray[np.bool_]
Complexes = NDArray[np.complex128]
Pixels = NDArray[np.uint8]  # an image, shape (h, w) or (h, w, channels)
