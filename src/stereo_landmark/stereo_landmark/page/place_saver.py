"""Saves places of a session without overwriting changes made elsewhere."""

import hashlib
from collections.abc import Iterable
from pathlib import Path

from shirube_core.files import exclusive_lock
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.stereo import StereoImages
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.files.place_file import place_path, save_place


class PlaceExistsError(StereoLandmarkError):
    """A place of this name exists and was created or changed elsewhere."""


class PlaceSaver:
    """Saves the places of one session.

    Args:
        folder: folder of the places.
        own: files that were loaded for editing and may be replaced.
    """

    def __init__(self, folder: Path, own: Iterable[Path] = ()) -> None:
        self._folder = folder
        self._own = {path: _digest(path) for path in own}

    def is_own(self, name: str) -> bool:
        """Return whether the place of this name was saved or loaded in this session."""
        return place_path(self._folder, name) in self._own

    def save(self, place: TaughtPlace, images: StereoImages, *, replace: bool = False) -> Path:
        """Write a place and return its file.

        Raises:
            PlaceExistsError: the place exists, was created or changed elsewhere, and must not be replaced.
            LandmarkFileError: the place is invalid.
            OSError: the folder is not writable.
        """
        path = place_path(self._folder, place.name)
        # Concurrent writers would leave images that belong to the other place.
        with exclusive_lock(self._folder):
            if path.exists() and not replace:
                self._check_own(path)
            save_place(self._folder, place, images, replace_damaged=replace)
            self._own[path] = _digest(path)
        return path

    def _check_own(self, path: Path) -> None:
        if path not in self._own:
            raise PlaceExistsError(f'{path} exists; replace it, or choose another name')
        if _digest(path) != self._own[path]:
            raise PlaceExistsError(f'{path} was changed elsewhere; replace it, or choose another name')


def _digest(path: Path) -> bytes:
    return hashlib.sha256(path.read_bytes()).digest()
