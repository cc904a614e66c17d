"""Debug image of the receiver."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.pose.pose_fix import BeaconFix
from vlc_beacon.core.receiver.beacon_receiver import ReceiverOutput

_IDENTIFIED, _UNKNOWN, _UNIDENTIFIED = (60, 220, 60), (40, 40, 230), (0, 200, 255)
_MARGIN = 3.0
"""Gap between a lamp and its circle [px]."""
_SUBPIXEL_BITS = 4
_TEXT = 0.5


def draw_debug_image(pixels: NDArray[np.uint8], output: ReceiverOutput) -> NDArray[np.uint8]:
    """Draw lamps with a known ID green, unknown ID red, no ID yellow, and the pose or the reason for none.

    Args:
        pixels: grey image, shape (h, w), or BGR image, shape (h, w, 3); not modified.
        output: receiver output of the image.

    Returns:
        BGR image, shape (h, w, 3).
    """
    coloured = cv2.cvtColor(pixels, cv2.COLOR_GRAY2BGR) if pixels.ndim == 2 else pixels
    canvas = np.array(coloured, dtype=np.uint8)
    unit = 1 << _SUBPIXEL_BITS
    for lamp in output.lamps:
        name = lamp.beacon if lamp.beacon is not None else lamp.unknown_id
        colour = _UNIDENTIFIED if name is None else _IDENTIFIED if lamp.beacon is not None else _UNKNOWN
        u, v = (float(position) for position in lamp.sample.centre)
        reach = lamp.sample.radius + _MARGIN
        centre = (round(u * unit), round(v * unit))
        cv2.circle(canvas, centre, round(reach * unit), colour, 1, cv2.LINE_AA, _SUBPIXEL_BITS)
        if name is not None:
            _put_text(canvas, str(name), (round(u + reach) + 2, round(v)), colour)
    _put_text(canvas, _headline(output), (4, 18), (255, 255, 255))
    return canvas


def _headline(output: ReceiverOutput) -> str:
    result = output.result
    if not isinstance(result, BeaconFix):
        return f'no fix: {result.reason.value}'
    pose = result.T_map_base
    return f'{pose.x:.3f} {pose.y:.3f} m {pose.yaw:.3f} rad'


def _put_text(
    canvas: NDArray[np.uint8], text: str, position: tuple[int, int], colour: tuple[int, int, int]
) -> None:
    for shade, width in (((0, 0, 0), 3), (colour, 1)):
        cv2.putText(canvas, text, position, cv2.FONT_HERSHEY_SIMPLEX, _TEXT, shade, width, cv2.LINE_AA)
