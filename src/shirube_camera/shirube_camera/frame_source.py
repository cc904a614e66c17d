"""Images of a V4L2 camera, a video file or a folder of images, behind one narrow interface, and their settings."""

import os
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from shirube_camera.core.calibration import ShirubeCameraError
from shirube_core.settings import setting, tunable
from shirube_ros.camera.files import list_images, load_image

_EXPOSURE_UNIT = 1e-4  # V4L2_CID_EXPOSURE_ABSOLUTE counts 100 µs [s]
_MANUAL, _AUTOMATIC = 1.0, 3.0  # V4L2_EXPOSURE_MANUAL, V4L2_EXPOSURE_APERTURE_PRIORITY
_TOLERANCE = 0.05  # relative difference of a control that the driver rounded
_REMEDY = 'give a camera (v4l2-ctl --list-devices), a video or a folder of images'
CONTROLS = ('width', 'height', 'rate', 'pixel_format', 'exposure_time', 'gain', 'focus')


@tunable('exposure_time', 'gain', 'focus')
@dataclass(frozen=True)
class CameraSettings:
    """Source of the images, and controls of the camera."""

    device: str = setting('/dev/video0', 'number, /dev/videoN or /dev/v4l/by-id/...; or a video or folder')
    width: int = setting(0, "width of the images; 0: the driver's", 'px', (0, 16384))
    height: int = setting(0, "height of the images; 0: the driver's", 'px', (0, 16384))
    rate: float = setting(0.0, "images/s; 0: the source's, 30 for a folder", limits=(0.0, 1e3))
    pixel_format: str = setting('', "such as YUYV, GREY (exact), MJPG (more images/s); empty: the driver's")
    exposure_time: float = setting(0.0, 'steps of 0.1 ms; 0: automatic', 's', (0.0, 1.0))
    gain: float = setting(-1.0, "gain in the driver's unit; -1: unchanged", limits=(-1.0, 1e5))
    focus: float = setting(-1.0, "fixed focus in the driver's unit; -1: unchanged", limits=(-1.0, 1e5))
    loop: bool = setting(False, 'whether a video or folder starts again at its end')


class Frame(NamedTuple):
    """Image, shape (h, w) or (h, w, 3), the driver's stamp on the monotonic clock [s], 0 without, and a file's name."""

    pixels: NDArray[np.uint8]
    stamp: float = 0.0
    name: str = ''


class FrameSource:
    """Images of a camera, a video or a folder.

    Attributes:
        is_live: whether it is a camera, which sets the pace and may come back after a failure.
        rate: nominal images per second, 0 if unknown.
        exposure_time: exposure time that the driver reports [s], 0 without one.
    """

    def __init__(self, settings: CameraSettings) -> None:
        """Open the source that ``device`` names; size, rate and pixel format can only be set now.

        Raises:
            ShirubeCameraError: the camera or file is absent, not permitted or in use.
            ImageFileError: the folder has no images.
        """
        device = f'/dev/video{settings.device}' if settings.device.isdecimal() else settings.device
        self.is_live, self.rate, self._loop = device.startswith('/dev/'), settings.rate or 30.0, settings.loop
        self.exposure_time = 0.0
        self._capture: Any = None
        if Path(device).is_dir():
            self._images = (cycle if self._loop else iter)(list_images([Path(device)]))
            return
        if not Path(device).exists():
            is_bare = self.is_live and not any(Path('/dev').glob('video*'))
            remedy = 'this computer has no V4L2 device: plug the camera in' if is_bare else _REMEDY
            raise ShirubeCameraError(f'{device} does not exist; {remedy}')
        if not os.access(device, os.R_OK):
            raise ShirubeCameraError(f'{device} is not permitted; add the user to the group video, log in again')
        # The link that names a camera is resolved at each start: the driver may have numbered its devices anew.
        self._capture = cv2.VideoCapture(os.path.realpath(device), cv2.CAP_V4L2 if self.is_live else cv2.CAP_ANY)
        if not self._capture.isOpened():
            raise ShirubeCameraError(f'{device} is in use by another program, or no camera or video; {_REMEDY}')
        for number, value in _controls(settings).values() if self.is_live else ():
            self._capture.set(number, value)
        driver_rate = float(self._capture.get(cv2.CAP_PROP_FPS))
        self.rate = driver_rate if self.is_live else settings.rate or driver_rate or 30.0

    def read(self) -> Frame | None:
        """Wait for the next image; None at the end, or if the camera fails; an ImageFileError if a file is no image."""
        if self._capture is None:
            path = next(self._images, None)
            return None if path is None else Frame(load_image(path), name=path.name)
        is_read, pixels = self._capture.read()
        if not is_read and self._loop and not self.is_live:
            self._capture.set(cv2.CAP_PROP_POS_FRAMES, 0)
            is_read, pixels = self._capture.read()
        stamp = 1e-3 * float(self._capture.get(cv2.CAP_PROP_POS_MSEC)) if self.is_live else 0.0
        return Frame(pixels, stamp) if is_read else None

    def apply(self, settings: CameraSettings) -> list[str]:
        """Set exposure, gain and focus of a camera; return what it did not take, one sentence each."""
        refused = []
        for name, (number, value) in _controls(settings).items() if self.is_live else ():
            if name not in CONTROLS[:4]:
                self._capture.set(number, value)
            taken = float(self._capture.get(number))
            if abs(taken - value) > _TOLERANCE * abs(value):
                refused.append(f'{name} is {_shown(name, taken)}, not {_shown(name, value)}')
        if self.is_live:
            self.exposure_time = _EXPOSURE_UNIT * float(self._capture.get(cv2.CAP_PROP_EXPOSURE))
        return refused

    def close(self) -> None:
        """Release the camera or file."""
        if self._capture is not None:
            self._capture.release()


def _shown(name: str, value: float) -> str:
    if name == 'pixel_format':
        return int(value).to_bytes(4, 'little').decode('ascii', 'replace')
    return f'{value * (_EXPOSURE_UNIT if name == "exposure_time" else 1.0):g}'


def _controls(settings: CameraSettings) -> dict[str, tuple[int, float]]:
    """Return OpenCV's number and the value of each control that is set, in the order in which drivers need them."""
    fourcc = float(cv2.VideoWriter.fourcc(*f'{settings.pixel_format:4.4}')) if settings.pixel_format else -1.0
    controls = {
        'pixel_format': (cv2.CAP_PROP_FOURCC, fourcc),
        'width': (cv2.CAP_PROP_FRAME_WIDTH, settings.width or -1.0),
        'height': (cv2.CAP_PROP_FRAME_HEIGHT, settings.height or -1.0),
        'rate': (cv2.CAP_PROP_FPS, settings.rate or -1.0),
        'exposure mode': (cv2.CAP_PROP_AUTO_EXPOSURE, _MANUAL if settings.exposure_time else _AUTOMATIC),
        'exposure_time': (cv2.CAP_PROP_EXPOSURE, round(settings.exposure_time / _EXPOSURE_UNIT) or -1.0),
        'gain': (cv2.CAP_PROP_GAIN, settings.gain),
        'focus mode': (cv2.CAP_PROP_AUTOFOCUS, 0.0 if settings.focus >= 0.0 else -1.0),
        'focus': (cv2.CAP_PROP_FOCUS, settings.focus),
    }
    return {name: control for name, control in controls.items() if control[1] >= 0.0}
