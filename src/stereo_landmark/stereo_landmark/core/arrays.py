"""Types of arrays; docstrings give their shapes and units."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Masks = NDArray[np.bool_]
GreyImage = NDArray[np.uint8]
