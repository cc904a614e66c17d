"""Checkpoint files of a survey, written atomically, from which an interrupted survey resumes."""

import hashlib
import json
import shutil
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numba
import numpy as np
import scipy
from numpy.typing import NDArray

import floor_localizer.core
import floor_localizer.survey_files
import shirube_core.geometry
from floor_localizer.core.dots import DetectedDots
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.survey.submap import Submap
from floor_localizer.files.array_file import DiskArrayStore
from shirube_core.files import atomic_write, remove_temporary_files, write_text

_PACKAGES = (floor_localizer.core, floor_localizer.survey_files, shirube_core.geometry)
_LIBRARIES = (cv2, numba, np, scipy)
# Raised by numpy and zipfile for files that are empty, truncated or corrupted.
_CORRUPTED = (OSError, EOFError, RuntimeError, ValueError, KeyError, zipfile.BadZipFile)


def code_version() -> str:
    """Return a version from the hash of all sources used by a survey and the versions of its numerical libraries.

    It changes without manual bumping, and therefore also with changes that do not affect the results.
    """
    digest = hashlib.sha256()
    for package in _PACKAGES:
        folder = Path(package.__path__[0])
        for source in sorted(folder.rglob('*.py')):
            digest.update(f'{package.__name__}/{source.relative_to(folder)}\n'.encode())
            digest.update(source.read_bytes())
    libraries = ', '.join(f'{library.__name__} {library.__version__}' for library in _LIBRARIES)
    return f'sources {digest.hexdigest()[:16]}, {libraries}'


Detection = DetectedDots | str  # the dots of an image, or why it cannot be used


class Checkpoint:
    """A folder of checkpoint files of one survey."""

    def __init__(self, folder: Path, survey: dict[str, object]) -> None:
        """Open or create a checkpoint.

        Args:
            folder: folder of the checkpoint files.
            survey: everything besides the code that the results depend on, by human-readable names.

        Raises:
            FloorLocalizerError: the folder holds another survey.
            OSError: the folder cannot be written to.
        """
        self._folder = folder.absolute()  # the tasks may run in another folder
        self._stores_folder = self._folder / 'adjustment'
        # In the form in which JSON reads it back.
        given = json.loads(json.dumps({**survey, 'version of the software': code_version()}))
        path = folder / 'survey.json'
        if not path.exists():
            write_text(path, json.dumps(given, indent=1))
        elif changed := _changed_inputs(path, given):
            raise FloorLocalizerError(
                f'{folder}: belongs to another survey, which differs by its {" and ".join(changed)}; '
                'remove it or choose another --out'
            )
        for names in ('*.npz', self.images_file.name, path.name):
            remove_temporary_files(folder, names)

    def remove_stores(self) -> None:
        """Remove the array stores; dots, submaps and finished steps are kept."""
        shutil.rmtree(self._stores_folder, ignore_errors=True)

    @property
    def images_file(self) -> Path:
        """File with the dots of all images."""
        return self._folder / 'images.bin'

    def create_store(self) -> DiskArrayStore:
        """Return an empty array store for graph and adjustment; remove the previous ones; raises `OSError`."""
        self.remove_stores()
        self._stores_folder.mkdir(parents=True)
        # A unique name, because tasks of a killed run may still be running on a cluster.
        return DiskArrayStore(Path(tempfile.mkdtemp(dir=self._stores_folder)))

    def load_step(self, step: str) -> dict[str, NDArray[Any]] | None:
        """Return the results of a pose graph or adjustment step, None if it is not finished."""
        return self._load(f'{step}.npz')

    def save_step(self, step: str, **arrays: NDArray[Any]) -> None:
        """Save the results of a step; raises `OSError`."""
        self._save(f'{step}.npz', **arrays)

    def load_dots(self, chunk: int) -> dict[int, Detection] | None:
        """Return the dots of a chunk by image index, None if they are not saved yet."""
        content = self._load(f'dots_{chunk:05d}.npz')
        if content is None:
            return None
        ends = np.cumsum(content['counts'])
        found: dict[int, Detection] = {}
        for k, index in enumerate(content['images'].tolist()):
            rows = content['dots'][ends[k] - content['counts'][k] : ends[k]]
            fault = str(content['faults'][k])
            found[index] = fault or DetectedDots(rows[:, :2].copy(), rows[:, 2].copy(), rows[:, 3].copy())
        return found

    def save_dots(self, chunk: int, found: dict[int, Detection]) -> None:
        """Save the dots of a chunk of images; raises `OSError`."""
        tables = [
            np.empty((0, 4)) if isinstance(dots, str) else np.column_stack([dots.pixels, dots.diameters, dots.sigmas])
            for dots in found.values()
        ]
        self._save(
            f'dots_{chunk:05d}.npz',
            images=np.array(list(found), dtype=np.int64),
            counts=np.array([len(table) for table in tables], dtype=np.int64),
            dots=np.concatenate(tables) if tables else np.empty((0, 4)),
            faults=np.array([dots if isinstance(dots, str) else '' for dots in found.values()], dtype=np.str_),
        )

    def load_submaps(self, span: int) -> list[Submap] | None:
        """Return the submaps of a span of images, None if they are not saved yet."""
        content = self._load(f'submaps_{span:05d}.npz')
        if content is None:
            return None
        submaps = []
        for k in range(int(content['number'])):
            images, states, dots, counts = (content[f'{k}_{name}'] for name in ('images', 'states', 'dots', 'counts'))
            submaps.append(Submap(images, states, dots, counts, bool(content[f'{k}_linked'])))
        return submaps

    def save_submaps(self, span: int, submaps: Sequence[Submap]) -> None:
        """Save the submaps of a span of images; raises `OSError`."""
        arrays: dict[str, object] = {'number': len(submaps)}
        for k, submap in enumerate(submaps):
            arrays |= {
                f'{k}_images': submap.images, f'{k}_states': submap.states, f'{k}_dots': submap.dots,
                f'{k}_counts': submap.counts, f'{k}_linked': submap.is_continuation,
            }  # fmt: skip
        self._save(f'submaps_{span:05d}.npz', **arrays)

    def _load(self, name: str) -> dict[str, NDArray[Any]] | None:
        try:
            with np.load(self._folder / name, allow_pickle=False) as content:
                return {key: content[key] for key in content} or None
        except _CORRUPTED:
            return None  # not finished, or corrupted: computed again

    def _save(self, name: str, **arrays: object) -> None:
        with atomic_write(self._folder / name) as file:
            np.savez(file, **arrays)  # type: ignore[arg-type]


def _changed_inputs(path: Path, given: dict[str, object]) -> list[str]:
    """Return the names of the inputs that differ from those of the checkpoint."""
    try:
        known = dict(json.loads(path.read_text()))
    except (ValueError, TypeError):
        known = {}
    return [name for name in given if known.get(name) != given[name]]
