"""Validates places at start: each must be found in its own images. This also compiles the numba kernels."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from stereo_landmark.core.landmark_fix import NoLandmarkFix
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer, LandmarkSettings
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.files.place_file import load_images, place_path


def validate_places(folder: Path, places: Iterable[TaughtPlace], settings: LandmarkSettings) -> list[str]:
    """Return a warning for each place that is not found in its own taught images.

    Args:
        folder: folder of the place files.
        places: places loaded from this folder.
        settings: settings of the search and the pose fit.

    Raises:
        StereoLandmarkError: an image is missing, corrupted or has the wrong size.
    """
    lines = []
    for place in places:
        images = load_images(place_path(folder, place.name))
        result = LandmarkLocalizer([place], settings).locate(images.left, images.right, images.tilt)
        if isinstance(result, NoLandmarkFix):
            lines.append(
                f'place {place.name} is not found in the images it was taught from: {result.reason} ({result.detail}); '
                'teach it with other targets, or correct the parameters'
            )
    return lines
