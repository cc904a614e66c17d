"""What the library accepts: checked images, cameras and numbers, and kernels that are compiled and announced."""

import os
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shirube_cli.kernel_cache import compiled_kernels, kernel_folder
from shirube_cli.kernel_registry import sets_of_packages
from shirube_cli.project import find_home
from shirube_core.geometry import PinholeCamera
from shirube_ros.camera.files import load_calibration


class InputError(ValueError):
    """An argument that cannot be used; the message is one line with the remedy."""


def choose_cache() -> None:
    """Let numba keep machine code where the command keeps it, unless NUMBA_CACHE_DIR is set; before it is imported."""
    os.environ.setdefault('NUMBA_CACHE_DIR', str(kernel_folder(find_home())))


@cache
def prepare(package: str) -> None:
    """Compile a package's kernels unless they are; prints how far it is. A cache of the caller's own is left alone."""
    home = find_home()
    if os.environ.get('NUMBA_CACHE_DIR') == str(kernel_folder(home)):
        compiled_kernels(home, sets_of_packages([package]))


def as_numbers(name: str, values: ArrayLike, shape: tuple[int | None, ...]) -> NDArray[np.float64]:
    """Return finite numbers of a shape, in which None is any length; raise an InputError for others."""
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as fault:
        raise InputError(f'{name} is no table of numbers; give rows of equal length') from fault
    fits = len(array.shape) == len(shape) and all(
        wanted in (None, length) for wanted, length in zip(shape, array.shape, strict=True)
    )
    if not fits:
        sizes = ' x '.join('n' if each is None else str(each) for each in shape)
        raise InputError(f'{name} has the shape {array.shape}; give {sizes} numbers')
    if not np.isfinite(array).all():
        raise InputError(f'{name} has a number that is not finite; leave such rows out')
    return array


def as_camera(camera: PinholeCamera | str | Path) -> PinholeCamera:
    """Return a camera, or read the YAML that camera_calibration writes."""
    if isinstance(camera, PinholeCamera):
        return camera
    if not isinstance(camera, str | Path):
        raise InputError(f'camera is {camera!r}; give a shirube.Camera or the path of a calibration')
    return load_calibration(Path(camera))


def as_image(image: ArrayLike, camera: PinholeCamera) -> NDArray[np.uint8]:
    """Return an image of a camera's size, shape (h, w) grey or (h, w, 3) BGR; raise an InputError for others."""
    try:
        array = np.asarray(image)
    except ValueError as fault:
        raise InputError('the image has rows of different lengths; give a rectangle of pixels') from fault
    if array.ndim not in (2, 3) or array.shape[2:] not in ((), (3,)):
        raise InputError(f'the image has the shape {array.shape}; give (h, w) grey or (h, w, 3) BGR')
    if array.shape[:2] != (camera.height, camera.width):
        raise InputError(
            f'the image is {array.shape[1]} x {array.shape[0]} px, its camera is calibrated for '
            f'{camera.width} x {camera.height} px; give images of that size, or calibrate at this one'
        )
    if array.dtype != np.uint8:
        if array.dtype.kind not in 'iu' or array.min() < 0 or array.max() > 255:
            raise InputError(f'the image has values of type {array.dtype}; give whole numbers from 0 to 255')
        array = array.astype(np.uint8)
    return np.ascontiguousarray(array)


def as_grey(image: ArrayLike, camera: PinholeCamera) -> NDArray[np.uint8]:
    """Return an image as `as_image`, with colours mixed to grey."""
    array = as_image(image, camera)
    weights = (0.114, 0.587, 0.299)
    return array if array.ndim == 2 else np.rint(array @ np.array(weights)).astype(np.uint8)


def as_triple(name: str, values: ArrayLike) -> tuple[float, float, float]:
    """Return three finite numbers; raise an InputError for others."""
    x, y, z = as_numbers(name, values, (3,)).tolist()
    return x, y, z
