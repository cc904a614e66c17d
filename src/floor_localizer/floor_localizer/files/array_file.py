"""Arrays in numpy's own form, written so that a full disk is told as such."""

from __future__ import annotations

import errno
from typing import IO, Any

import numpy as np
from numpy.lib import format as numpy_form
from numpy.typing import NDArray

NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""What the system says where there is no room for a file."""


def write_array(file: IO[bytes], array: NDArray[Any]) -> None:
    """Write an array as `numpy.save` does, but through the file itself.

    Numpy writes to the disk past the file: a disk that fills up is told without saying so, or not at all.

    Args:
        file: open for writing.
        array: of any shape.

    Raises:
        OSError: the place cannot be written to; one of `NO_ROOM` where the disk is full.
    """
    whole = np.asarray(array, order='C')
    numpy_form.write_array_header_1_0(file, numpy_form.header_data_from_array_1_0(whole))
    file.write(whole.data)
