"""Reads and writes taught places: one YAML file with the five sections of the paper (3.3), and its stereo pair."""

import hashlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from shirube_core.files import atomic_write, write_text
from shirube_ros.errors import ImageFileError
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.stereo import StereoImages
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.files.camera_files import encode_png, load_grey_image
from stereo_landmark.files.place_entries import place_entries, place_from_entries
from stereo_landmark.files.yaml_file import LandmarkFileError, check_schema, find_non_finite, read_yaml

FORMAT, VERSION = 'shirube/taught_place', 1
_REMEDY = 'restore the file or teach the place again'


class NotAPlaceFileError(LandmarkFileError):
    """The YAML file is not a taught place, and must not be overwritten."""


def place_path(folder: Path, name: str) -> Path:
    """Return the file of a place."""
    return folder / f'{name}.yaml'


def save_place(folder: Path, place: TaughtPlace, images: StereoImages, *, replace_damaged: bool = False) -> Path:
    """Write a place atomically and return its file.

    Shapes are written without their covariance, which belongs to the images and not to the place.

    Args:
        folder: folder of the places.
        place: place to write.
        images: images used for teaching.
        replace_damaged: whether to overwrite a place that cannot be loaded any more.

    Raises:
        LandmarkFileError: the place could not be loaded again, or a file that is not a place has its name.
        OSError: the folder is not writable.
    """
    path = place_path(folder, place.name)
    entries = to_plain({'format': FORMAT, 'version': VERSION, **place_entries(place)})
    _validate_entries(path, entries)
    earlier = _existing_images(path, replace_damaged) if path.exists() else {}
    written = write_images(folder, place.name, images)
    text = yaml.safe_dump(
        {**entries, 'images': written}, sort_keys=False, default_flow_style=None, allow_unicode=True, width=110
    )
    write_text(path, text)
    stale = {str(earlier[side]) for side in ('left', 'right') if earlier} - {*map(str, written.values())}
    for name in stale:
        if not _is_referenced_elsewhere(folder, path, name):
            (folder / name).unlink(missing_ok=True)
    return path


def _existing_images(path: Path, replace_damaged: bool) -> dict[str, Any]:
    """Return the images of the place that will be overwritten, none if it is too corrupted to list them."""
    try:
        return dict(_read(path)['images'])
    except NotAPlaceFileError:
        raise
    except LandmarkFileError:
        if replace_damaged:
            return {}
        raise


def _is_referenced_elsewhere(folder: Path, path: Path, image: str) -> bool:
    """Return whether another place file in the folder refers to the image, for example a manual copy."""
    others = (other for other in folder.glob('*.yaml') if other != path)
    return any(image.encode() in other.read_bytes() for other in others)


def load_place(path: Path) -> TaughtPlace:
    """Load a place.

    Raises:
        LandmarkFileError: the file is malformed; the message names file, field and remedy.
    """
    return _place_from(path, _read(path))


def _place_from(path: Path, entries: dict[str, Any]) -> TaughtPlace:
    try:
        return place_from_entries(entries)
    except StereoLandmarkError as fault:
        raise LandmarkFileError(f'{path}: {fault}') from fault


def load_images(path: Path) -> StereoImages:
    """Load the stereo pair that was used for teaching a place.

    Raises:
        LandmarkFileError: the place file is malformed, or an image is missing or corrupted.
    """
    return read_images(path, _read(path)['images'])


def load_places(folder: Path) -> list[TaughtPlace]:
    """Load all places of a folder with their images, sorted by file name.

    Raises:
        LandmarkFileError: the folder is missing or has no places, or one of them is malformed.
    """
    if not folder.is_dir():
        raise LandmarkFileError(f'{folder}: is not a folder; give the folder with the taught places')
    paths = sorted(folder.glob('*.yaml'))
    if not paths:
        raise LandmarkFileError(f'{folder}: contains no taught place (*.yaml); teach one')
    return [_load_with_images(path) for path in paths]


def _load_with_images(path: Path) -> TaughtPlace:
    """Return a place with its images, without them if they are missing: outlines suffice for localization."""
    entries = _read(path)
    place = _place_from(path, entries)
    try:
        return replace(place, images=read_images(path, entries['images']))
    except LandmarkFileError:
        return place


def _read(path: Path) -> dict[str, Any]:
    content = read_yaml(path, _REMEDY)
    if content.get('format') != FORMAT:
        raise NotAPlaceFileError(f'{path}: format is not {FORMAT}, so it is not a taught place; move it elsewhere')
    version = content.get('version')
    if isinstance(version, int) and version > VERSION:
        raise LandmarkFileError(
            f'{path}: version is {version}, this program supports up to {VERSION}; update stereo_landmark'
        )
    check_schema(content, 'place_schema', str(path), _REMEDY)
    if content['name'] != path.stem:
        raise LandmarkFileError(
            f'{path}: name is {content["name"]}, but the file is called {path.stem}; use the same name for both'
        )
    return content


def _validate_entries(path: Path, entries: dict[str, Any]) -> None:
    """Reject entries that could not be loaded again."""
    remedy = 'correct it'
    images = {'left': 'left.png', 'right': 'right.png', 'tilt': [0.0, 0.0]}
    check_schema({**entries, 'images': images}, 'place_schema', str(path), remedy)
    non_finite = find_non_finite(entries)
    if non_finite is not None:
        raise LandmarkFileError(f'{path}: {non_finite} is not a finite number; {remedy}')
    _place_from(path, entries)


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


def to_plain(content: Any) -> Any:
    """Return nested content with lists instead of arrays and tuples, and Python numbers, without loss of precision."""
    if isinstance(content, dict):
        return {name: to_plain(value) for name, value in content.items()}
    if isinstance(content, (list, tuple)):
        return [to_plain(value) for value in content]
    return content.tolist() if isinstance(content, (np.ndarray, np.generic)) else content
