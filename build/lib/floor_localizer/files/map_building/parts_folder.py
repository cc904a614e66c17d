"""Folder with the finished parts of a build, from which an interrupted build resumes."""

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.errors import DotMapError
from floor_localizer.files.array_file import write_array
from shirube_core.files import atomic_write, write_text


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
        """Create the folder, or resume in it; ``job`` is everything that the result depends on.

        Raises:
            DotMapError: the folder holds another build.
        """
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
