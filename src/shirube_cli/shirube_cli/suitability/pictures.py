"""Pictures from photographs, films and folders of images, and what all trials share."""

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from shirube.inputs import prepare
from shirube_cli.project import CommandError

Image = NDArray[np.uint8]
_SUFFIXES = {'.png', '.jpg', '.jpeg', '.bmp', '.tif', '.tiff', '.webp'}
_SIDE_MIN = 64  # of a picture [px]


class Film(NamedTuple):
    """Pictures, shape (h, w, 3) blue, green, red, and how many there are a second; NaN for photographs."""

    pictures: list[Image]
    rate: float = float('nan')


def read_film(path: Path, count: int, *, spread: bool = False) -> Film:
    """Return the first, or spread, pictures of a file or folder as the sensor stored them; raises `CommandError`."""
    if path.is_dir() or path.suffix.lower() in _SUFFIXES:
        files = sorted(each for each in path.iterdir() if each.suffix.lower() in _SUFFIXES) if path.is_dir() else [path]
        kind = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
        step = max(len(files) // count, 1) if spread else 1
        read = (cv2.imread(str(each), kind) for each in files[::step][:count] if each.is_file())
        film = Film([np.asarray(picture, np.uint8) for picture in read if picture is not None])
    else:
        capture = cv2.VideoCapture(str(path))
        frames = int(capture.get(cv2.CAP_PROP_FRAME_COUNT)) if capture.isOpened() else 0
        step = max(frames // count, 1) if spread else 1
        film = Film(list(_frames(capture, step, count)), capture.get(cv2.CAP_PROP_FPS) or float('nan'))
        capture.release()
    if not film.pictures:
        why = 'no picture can be read' if path.exists() else 'there is no such file'
        raise CommandError(f'{path}: {why}; give a photograph, a film or a folder of images')
    if min(film.pictures[0].shape[:2]) < _SIDE_MIN:
        raise CommandError(f'{path}: the picture is too small; give one of {_SIDE_MIN} x {_SIDE_MIN} px or more')
    return film


def _frames(capture: cv2.VideoCapture, step: int, count: int) -> Iterator[Image]:
    for _ in range(count):
        is_read, frame = capture.read()
        if not is_read:
            return
        yield np.asarray(frame, np.uint8)
        for _ in range(step - 1):
            capture.grab()


def grey(picture: Image) -> Image:
    """Return a picture in grey, shape (h, w)."""
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), np.uint8)


def parse(parser: argparse.ArgumentParser, arguments: Sequence[str], package: str) -> argparse.Namespace:
    """Return the options, all numbers of which must be positive, and compile the kernels of a package."""
    options = parser.parse_args(arguments)
    for name, value in vars(options).items():
        if isinstance(value, int | float) and not 0.0 < value < float('inf') and not isinstance(value, bool):
            parser.error(f'--{name.replace("_", "-")} is {value}; give a number above 0')
    prepare(package)
    return options
