"""Images of discs by supersampling, for a camera that looks straight up."""

from dataclasses import dataclass

import cv2
import numpy as np
from _lamp_room import CAMERA, LAMP_RADIUS
from numpy.typing import NDArray

FINE = 6
BLUR = 0.6  # of the lens [px]


@dataclass(frozen=True)
class Light:
    """How the room and the lamps look.

    Attributes:
        name: name in the table.
        ceiling: level of the ceiling in the middle of the image [grey levels].
        gradient: brightness of the right edge above the left edge [grey levels].
        lamp: brightness of a lamp over it [grey levels].
        noise: standard deviation of a pixel [grey levels].
        motion: motion blur during the exposure [px].
    """

    name: str
    ceiling: float
    gradient: float
    lamp: float
    noise: float
    motion: int = 1


LIGHTS = (
    Light('dark room, lamps bright', 4.0, 0.0, 200.0, 1.5),
    Light('lit room', 70.0, 30.0, 120.0, 2.0),
    Light('contrast 7 of 255', 4.0, 0.0, 7.0, 1.0),
    Light('contrast 7 of 255 in a lit room', 40.0, 15.0, 7.0, 1.5),
    Light('8 px motion blur', 4.0, 0.0, 200.0, 1.5, 8),
)


def picture_of(pixels: NDArray[np.float64], light: Light, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Return an image with lamps at places, shape (n, 2) [px]."""
    lamps = np.zeros((CAMERA.height, CAMERA.width))
    for place in pixels:
        _add_disc(lamps, place)
    return finish_picture(lamps, light, rng)


def finish_picture(shapes: NDArray[np.float64], light: Light, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Return the image of shapes, shape (h, w), 1 where they are bright, before the ceiling."""
    if light.motion > 1:
        shapes = _motion_blurred(shapes, light.motion)
    picture = light.ceiling + light.gradient * np.linspace(-0.5, 0.5, CAMERA.width)
    picture = picture + light.lamp * shapes + light.noise * rng.standard_normal(shapes.shape)
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def _motion_blurred(lamps: NDArray[np.float64], motion: int) -> NDArray[np.float64]:
    """Smear along u, centred on the middle of the exposure."""
    kernel = np.ones((1, motion + 1)) / motion
    # An even number of pixels is centred by halves at both ends.
    kernel[0, [0, -1]] *= 0.5
    return np.asarray(cv2.filter2D(lamps, -1, kernel))


def _add_disc(lamps: NDArray[np.float64], place: NDArray[np.float64]) -> None:
    reach = LAMP_RADIUS + 5.0
    left, top = np.maximum(np.floor(place - reach), 0).astype(int)
    right, bottom = np.minimum(np.ceil(place + reach) + 1, (CAMERA.width, CAMERA.height)).astype(int)
    x = (np.arange((right - left) * FINE) + 0.5) / FINE - 0.5 + left - place[0]
    y = (np.arange((bottom - top) * FINE) + 0.5)[:, None] / FINE - 0.5 + top - place[1]
    disc = cv2.GaussianBlur((x**2 + y**2 <= LAMP_RADIUS**2).astype(np.float64), (0, 0), BLUR * FINE)
    lamps[top:bottom, left:right] += disc.reshape(bottom - top, FINE, right - left, FINE).mean(axis=(1, 3))
