"""Keeps what was taught in a folder, and overwrites nobody's work by accident."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.core.teaching.teaching_session import StereoImages
from stereo_landmark.files.place_file import place_path, save_place
from stereo_landmark.files.taught_images import TaughtImages


class PlaceExistsError(StereoLandmarkError):
    """A place of the name is in the folder, and it was not made here."""


class PlaceSaver:
    """Saves places of one session.

    Args:
        folder: for the files.
        mine: files that are taught further, and so may be replaced.
    """

    def __init__(self, folder: Path, mine: Iterable[Path] = ()) -> None:
        self._folder = folder
        self._mine = set(mine)

    def save(self, place: TaughtPlace, images: StereoImages, *, replace: bool = False) -> Path:
        """Write a place and return its file.

        Args:
            place: what was taught.
            images: from which.
            replace: whether a place of the same name from elsewhere is given up.

        Raises:
            PlaceExistsError: there is one, and it shall be kept.
            LandmarkFileError: the place cannot be written.
            OSError: the folder cannot be written to.
        """
        path = place_path(self._folder, place.name)
        if path.exists() and not replace and path not in self._mine:
            raise PlaceExistsError(f'{path} is there already; replace it, or choose another name')
        pair = TaughtImages(images.left, images.right, images.tilt)
        save_place(self._folder, place, pair, replace_damaged=replace)
        self._mine.add(path)
        return path
