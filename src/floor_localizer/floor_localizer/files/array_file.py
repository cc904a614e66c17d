"""Arrays in files: numpy's npy format, written so that a full disk is reported as such, and a store of such files."""

import errno
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as numpy_format
from numpy.typing import NDArray

from floor_localizer.core.errors import FloorLocalizerError
from shirube_core.files import atomic_write

DISK_FULL_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Errors of the system when the disk is full."""


def write_array(file: IO[bytes], array: NDArray[Any]) -> None:
    """Write an array in the format of `numpy.save`, but through the file object.

    Numpy bypasses the file object and reports a full disk with a misleading error, or not at all.

    Raises:
        OSError: the file cannot be written; with one of `DISK_FULL_ERRORS` if the disk is full.
    """
    contiguous = np.asarray(array, order='C')
    numpy_format.write_array_header_1_0(file, numpy_format.header_data_from_array_1_0(contiguous))
    file.write(contiguous.data)


@dataclass(frozen=True)
class DiskArrayStore:
    """Arrays in files of a folder; they are read completely, so the page cache does not count as process memory.

    Attributes:
        folder: folder of the files, visible to all workers under the same path.
    """

    folder: Path

    def put(self, name: str, number: int, *arrays: NDArray[Any]) -> None:
        """Store arrays in place of those of the same name and number; raises `OSError`."""
        with atomic_write(self._path(name, number)) as file:
            for array in arrays:
                write_array(file, array)

    def get(self, name: str, number: int) -> tuple[NDArray[Any], ...]:
        """Return stored arrays; raises `FloorLocalizerError`: the file is not in this folder."""
        arrays = []
        try:
            with self._path(name, number).open('rb') as file:
                while file.peek(1):
                    arrays.append(np.load(file, allow_pickle=False))
        except FileNotFoundError as fault:
            raise _missing(fault) from fault
        return tuple(arrays)

    def memory_map(self, name: str) -> NDArray[Any]:
        """Return the first array of number 0, read-only and memory-mapped.

        Raises:
            FloorLocalizerError: the file is not in this folder.
        """
        try:
            return np.asarray(np.load(self._path(name, 0), mmap_mode='r', allow_pickle=False))
        except FileNotFoundError as fault:
            raise _missing(fault) from fault

    def _path(self, name: str, number: int) -> Path:
        return self.folder / f'{name}_{number:05d}.npy'


def _missing(fault: FileNotFoundError) -> FloorLocalizerError:
    return FloorLocalizerError(
        f'{fault.filename}: is missing although another process wrote it; '
        'use workers that see the same files under the same names'
    )
