"""A shelf of arrays on the disk, for one run: what lies there before is of a run that was killed."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floor_localizer.files.array_file import write_array
from shirube_files import written_beside


class ShelfFolder:
    """Arrays in files of a folder; they are read whole, so the page cache does not count as this process's memory."""

    def __init__(self, folder: Path) -> None:
        """Begin with an empty folder."""
        self._folder = folder
        self.remove()

    def put(self, name: str, number: int, *arrays: NDArray[Any]) -> None:
        """Put arrays away; they replace those of the same name and number.

        Raises:
            OSError: there is no room on the disk.
        """
        with written_beside(self._path(name, number)) as file:
            for array in arrays:
                write_array(file, array)

    def get(self, name: str, number: int) -> tuple[NDArray[Any], ...]:
        """Return arrays that were put away."""
        arrays = []
        with self._path(name, number).open('rb') as file:
            while file.peek(1):
                arrays.append(np.load(file, allow_pickle=False))
        return tuple(arrays)

    def remove(self) -> None:
        """Remove everything."""
        shutil.rmtree(self._folder, ignore_errors=True)

    def _path(self, name: str, number: int) -> Path:
        return self._folder / f'{name}_{number:05d}.npy'
