"""Arrays in files: numpy's npy format, written so that a full disk is reported as such, and a store of such files."""

import errno
import json
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as numpy_format
from numpy.typing import NDArray

from floor_localizer.core.errors import DotMapError, FloorLocalizerError
from shirube_core.files import atomic_write, write_text

DISK_FULL_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)  # errors of the system when the disk is full


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
        """Return the first array of number 0, read-only and memory-mapped; FloorLocalizerError if it is missing."""
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


class PartsFolder:
    """Files of one build: arrays of its tasks, and a result for each finished task."""

    def __init__(self, folder: Path) -> None:
        """Set the folder; `begin` creates it."""
        self._folder = folder

    @property
    def map_file(self) -> Path:
        """The partially written map."""
        return self._folder / 'map'

    def begin(self, job: dict[str, Any]) -> None:
        """Create the folder, or resume in it; raise a DotMapError if its ``job``, all inputs, is another one."""
        path, text = self._folder / 'job.json', json.dumps(job, sort_keys=True)
        if not path.exists():
            write_text(path, text)
        elif path.read_text() != text:
            raise DotMapError(
                f'{self._folder}: contains parts of the index of another map or version; '
                'remove it or choose another --out'
            )

    def load_result(self, stage: str, task: int) -> Any | None:
        """Return the result of a task, None if it is not finished."""
        try:
            return json.loads((self._folder / f'{stage}-{task:05d}.json').read_text())
        except (FileNotFoundError, ValueError):
            return None

    def finish(self, stage: str, task: int, result: Any) -> None:
        """Mark a task as finished and save its result; its arrays are written before."""
        write_text(self._folder / f'{stage}-{task:05d}.json', json.dumps(result))

    def save(self, name: str, task: int, array: NDArray[Any]) -> None:
        """Write an array of a task atomically."""
        with atomic_write(self._folder / f'{name}-{task:05d}.npy') as file:
            write_array(file, array)

    def load(self, name: str, task: int) -> NDArray[Any]:
        """Return an array of a task, memory-mapped."""
        loaded: NDArray[Any] = np.load(self._folder / f'{name}-{task:05d}.npy', mmap_mode='r')
        return loaded

    def load_all(self, name: str, tasks: int) -> Iterator[NDArray[Any]]:
        """Yield the arrays of the first ``tasks`` tasks in order."""
        for task in range(tasks):
            yield self.load(name, task)

    def remove_arrays(self, name: str) -> None:
        """Remove the arrays of a name."""
        for path in self._folder.glob(f'{name}-*.npy'):
            path.unlink()

    def remove(self) -> None:
        """Remove the folder."""
        shutil.rmtree(self._folder)
