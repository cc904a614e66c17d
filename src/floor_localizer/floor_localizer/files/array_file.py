"""Arrays in numpy's npy format, written so that a full disk is reported as such."""

from __future__ import annotations

import errno
from typing import IO, Any

import numpy as np
from numpy.lib import format as numpy_format
from numpy.typing import NDArray

DISK_FULL_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Errors of the system when the disk is full."""


def write_array(file: IO[bytes], array: NDArray[Any]) -> None:
    """Write an array in the format of `numpy.save`, but through the file object.

    Numpy bypasses the file object and reports a full disk with a misleading error, or not at all.

    Args:
        file: open for writing.
        array: array of any shape.

    Raises:
        OSError: the file cannot be written; with one of `DISK_FULL_ERRORS` if the disk is full.
    """
    contiguous = np.asarray(array, order='C')
    numpy_format.write_array_header_1_0(file, numpy_format.header_data_from_array_1_0(contiguous))
    file.write(contiguous.data)
