"""Debug image of the receiver."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.pose.pose_fix import BeaconFix
from vlc_beacon.core.receiver.beacon_receiver import Reception

_NAMED, _STRANGER, _SILENT = (60, 220, 60), (40, 40, 230), (0, 200, 255)
_MARGIN = 3.0
"""Gap between a lamp and its circle [px]."""
_SUBPIXEL_BITS = 4
_TEXT = 0.5


def debug_picture(pixels: NDArray[np.uint8], reception: Reception) -> NDArray[np.uint8]:
    """Draw lamps with a known ID green, unknown ID red, no ID yellow, and the pose or the reason for none.

    Args:
        pixels: grey image, shape (h, w), or BGR image, shape (h, w, 3); not modified.
        reception: receiver output of the image.

    Returns:
        BGR image, shape (h, w, 3).
    """
    coloured = cv2.cvtColor(pixels, cv2.COLOR_GRAY2BGR) if pixels.ndim == 2 else pixels
    picture = np.array(coloured, dtype=np.uint8)
    unit = 1 << _SUBPIXEL_BITS
    for lamp in reception.lamps:
        name = lamp.beacon if lamp.beacon is not None else lamp.stranger
        colour = _SILENT if name is None else _NAMED if lamp.beacon is not None else _STRANGER
        u, v = (float(place) for place in lamp.sample.centre)
        reach = lamp.sample.radius + _MARGIN
        centre = (round(u * unit), round(v * unit))
        cv2.circle(picture, centre, round(reach * unit), colour, 1, cv2.LINE_AA, _SUBPIXEL_BITS)
        if name is not None:
            _write(picture, str(name), (round(u + reach) + 2, round(v)), colour)
    _write(picture, _headline(reception), (4, 18), (255, 255, 255))
    return picture


def _headline(reception: Reception) -> str:
    result = reception.result
    if not isinstance(result, BeaconFix):
        return f'no fix: {result.reason.value}'
    pose = result.T_map_base
    return f'{pose.x:.3f} {pose.y:.3f} m {pose.yaw:.3f} rad'


def _write(
    picture: NDArray[np.uint8], text: str, place: tuple[int, int], colour: tuple[int, int, int]
) -> None:
    for shade, width in (((0, 0, 0), 3), (colour, 1)):
        cv2.putText(picture, text, place, cv2.FONT_HERSHEY_SIMPLEX, _TEXT, shade, width, cv2.LINE_AA)
