"""The folder in which a map is built: what is done so far, so that a build that was killed goes on."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floor_localizer.files.array_file import write_array
from floor_localizer.files.file_errors import DotMapError
from shirube_files import write_text, written_beside


class PartsFolder:
    """Files of one build: arrays of single tasks, and for each task that is done what it told."""

    def __init__(self, folder: Path) -> None:
        """Name the folder; `begin` makes it."""
        self._folder = folder

    @property
    def map_file(self) -> Path:
        """The map as far as it is written."""
        return self._folder / 'map'

    def begin(self, job: dict[str, Any]) -> None:
        """Make the folder, or go on in it.

        Args:
            job: everything that the result depends on.

        Raises:
            DotMapError: the folder holds another build.
        """
        path, text = self._folder / 'job.json', json.dumps(job, sort_keys=True)
        if not path.exists():
            write_text(path, text)
        elif path.read_text() != text:
            raise DotMapError(
                f'{self._folder}: holds parts of the index of another map or version; '
                'remove it or choose another --out'
            )

    def result_of(self, stage: str, task: int) -> Any | None:
        """Return what a task told, None if it is not done."""
        try:
            return json.loads((self._folder / f'{stage}-{task:05d}.json').read_text())
        except (FileNotFoundError, ValueError):
            return None

    def finish(self, stage: str, task: int, result: Any) -> None:
        """Note that a task is done and what it tells; its arrays are written before."""
        write_text(self._folder / f'{stage}-{task:05d}.json', json.dumps(result))

    def save(self, name: str, task: int, array: NDArray[Any]) -> None:
        """Write an array of a task, whole or not at all."""
        with written_beside(self._folder / f'{name}-{task:05d}.npy') as file:
            write_array(file, array)

    def load(self, name: str, task: int) -> NDArray[Any]:
        """Return an array of a task, memory-mapped."""
        loaded: NDArray[Any] = np.load(self._folder / f'{name}-{task:05d}.npy', mmap_mode='r')
        return loaded

    def load_all(self, name: str, tasks: int) -> Iterator[NDArray[Any]]:
        """Yield the arrays of the first tasks in order."""
        for task in range(tasks):
            yield self.load(name, task)

    def drop(self, name: str) -> None:
        """Remove arrays that are not needed any more."""
        for path in self._folder.glob(f'{name}-*.npy'):
            path.unlink()

    def remove(self) -> None:
        """Remove the folder."""
        shutil.rmtree(self._folder)
