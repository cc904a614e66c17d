"""Stereo pair of a place that is being edited."""

from __future__ import annotations

from pathlib import Path

from stereo_landmark.files.place_file import load_images, load_place
from stereo_landmark.page.pair_source import RecordedPairs


def taught_pair(path: Path) -> RecordedPairs:
    """Return the stereo pair used for teaching a place.

    Raises:
        LandmarkFileError: the place is malformed.
    """
    images = load_images(path)
    return RecordedPairs(['as taught'], lambda _: images, load_place(path).rig)
