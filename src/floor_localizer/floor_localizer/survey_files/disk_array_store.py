"""Array store on disk."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.files.array_file import write_array
from shirube_core.files import atomic_write


@dataclass(frozen=True)
class DiskArrayStore:
    """Arrays in files of a folder; they are read completely, so the page cache does not count as process memory.

    Attributes:
        folder: folder of the files, visible to all workers under the same path.
    """

    folder: Path

    def put(self, name: str, number: int, *arrays: NDArray[Any]) -> None:
        """Store arrays; they replace those of the same name and number.

        Raises:
            OSError: the disk is full.
        """
        with atomic_write(self._path(name, number)) as file:
            for array in arrays:
                write_array(file, array)

    def get(self, name: str, number: int) -> tuple[NDArray[Any], ...]:
        """Return stored arrays.

        Raises:
            FloorLocalizerError: the file is not in this folder.
        """
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
