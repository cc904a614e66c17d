"""Keeps what was taught in a folder, and overwrites nobody's work by accident."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path

from shirube_files import locked
from stereo_landmark.core.pair.stereo_images import StereoImages
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.files.place_file import place_path, save_place


class PlaceExistsError(StereoLandmarkError):
    """A place of the name is in the folder, and it is not as it was left here."""


class PlaceSaver:
    """Saves places of one session.

    Args:
        folder: for the files.
        mine: files that are taught further, and so may be replaced.
    """

    def __init__(self, folder: Path, mine: Iterable[Path] = ()) -> None:
        self._folder = folder
        self._mine = {path: _digest(path) for path in mine}

    def is_mine(self, name: str) -> bool:
        """Return whether the place of a name was taught or loaded here."""
        return place_path(self._folder, name) in self._mine

    def save(self, place: TaughtPlace, images: StereoImages, *, replace: bool = False) -> Path:
        """Write a place and return its file.

        Args:
            place: what was taught.
            images: from which.
            replace: whether a place of the same name from elsewhere is given up.

        Raises:
            PlaceExistsError: there is one that was made or changed elsewhere, and it shall be kept.
            LandmarkFileError: the place cannot be written.
            OSError: the folder cannot be written to.
        """
        path = place_path(self._folder, place.name)
        # Pages that save at the same time would leave images that belong to the other's place.
        with locked(self._folder):
            if path.exists() and not replace:
                self._check_mine(path)
            save_place(self._folder, place, images, replace_damaged=replace)
            self._mine[path] = _digest(path)
        return path

    def _check_mine(self, path: Path) -> None:
        if path not in self._mine:
            raise PlaceExistsError(f'{path} is there already; replace it, or choose another name')
        if _digest(path) != self._mine[path]:
            raise PlaceExistsError(
                f'{path} was changed by somebody else since; replace it, or choose another name'
            )


def _digest(path: Path) -> bytes:
    return hashlib.sha256(path.read_bytes()).digest()
