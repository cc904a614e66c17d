"""BoofCV's printed random-dot pages, their photographs and cameras (BoofCV-Data, CC BY 4.0)."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from shirube_core.geometry import PinholeCamera

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

FOLDER = 'floor_random_dots'
CENTIMETRE = 0.01  # [m]


def load_pages(folder: Path) -> list[Array]:
    """Return the dots of the 120 pages, each of shape (30, 2) [m], x to the right and y up on the printed page.

    The file counts centimetres from the page's centre with y down the page, as the photographs show.
    """
    with (folder / 'descriptions.yaml').open() as file:
        description = yaml.load(file, Loader=yaml.CSafeLoader)
    return [np.array(marker) * (CENTIMETRE, -CENTIMETRE) for marker in description['markers']]


def load_camera(path: Path) -> PinholeCamera:
    """Return the camera of one of BoofCV's intrinsics files."""
    with path.open() as file:
        intrinsics = yaml.safe_load(file)
    pinhole, lens = intrinsics['pinhole'], intrinsics['radial_tangential']
    k1, k2 = lens['radial']
    return PinholeCamera(
        pinhole['width'],
        pinhole['height'],
        pinhole['fx'],
        pinhole['fy'],
        pinhole['cx'],
        pinhole['cy'],
        (k1, k2, lens['t1'], lens['t2'], 0.0),
    )


def undistort_image(image: Image, camera: PinholeCamera) -> Image:
    """Return the image as a camera with the same matrix and no distortion would have taken it."""
    return np.asarray(cv2.undistort(image, camera.matrix, np.array(camera.distortion)), dtype=np.uint8)


def load_photograph(folder: Path) -> tuple[Image, PinholeCamera]:
    """Return ``image00.jpg``, grey and undistorted, and its camera."""
    camera = load_camera(folder / 'intrinsic.yaml')
    image = cv2.imread(str(folder / 'image00.jpg'), cv2.IMREAD_GRAYSCALE)
    return undistort_image(np.asarray(image, dtype=np.uint8), camera), camera


def load_movie_camera(folder: Path) -> PinholeCamera:
    """Return the camera of ``movie.mp4``."""
    return load_camera(folder / 'movie_intrinsic.yaml')


def movie_images(folder: Path, step: int = 1) -> Iterator[tuple[int, Image]]:
    """Yield number and image, grey and undistorted, of every ``step``-th frame of ``movie.mp4``."""
    camera = load_movie_camera(folder)
    movie = cv2.VideoCapture(str(folder / 'movie.mp4'))
    number = 0
    while True:
        there, image = movie.read()
        if not there:
            break
        if number % step == 0:
            grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
            yield number, undistort_image(np.asarray(grey, dtype=np.uint8), camera)
        number += 1
    movie.release()
