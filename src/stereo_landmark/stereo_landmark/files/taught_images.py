"""Reads and writes the stereo pair of a taught place, in the folder of the place."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

from shirube_core.files import atomic_write
from shirube_ros.errors import ImageFileError
from stereo_landmark.core.pair.stereo_images import StereoImages
from stereo_landmark.files.grey_image import encode_png, load_grey_image
from stereo_landmark.files.yaml_file import LandmarkFileError


def write_images(folder: Path, name: str, images: StereoImages) -> dict[str, Any]:
    """Write the images and return the file entry that refers to them.

    File names contain a hash of the content, so that images of the previous state stay valid until it is replaced.

    Raises:
        OSError: the folder is not writable.
    """
    entry: dict[str, Any] = {}
    for side, image in (('left', images.left), ('right', images.right)):
        data = encode_png(image)
        entry[side] = f'{name}_{side}_{hashlib.sha256(data).hexdigest()[:8]}.png'
        with atomic_write(folder / entry[side]) as file:
            file.write(data)
    return {**entry, 'tilt': [float(angle) for angle in images.tilt]}


def read_images(path: Path, entry: dict[str, Any]) -> StereoImages:
    """Return the images that the entry of a place file refers to.

    Raises:
        LandmarkFileError: an image is missing or corrupted.
    """
    loaded = []
    for side in ('left', 'right'):
        try:
            loaded.append(load_grey_image(path.parent / entry[side]))
        except ImageFileError as fault:
            raise LandmarkFileError(f'{path}: images.{side}: {fault}') from fault
    roll, pitch = map(float, entry['tilt'])
    return StereoImages(loaded[0], loaded[1], (roll, pitch))
