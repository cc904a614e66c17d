"""Selection of views that differ, and advice on what to photograph next."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from shirube_camera.core.board import Array, BoardView
from shirube_camera.core.calibration import Calibration

VIEWS_MAX = 40
"""Number of views that are used at most."""
_DIFFERENCE_MIN = 0.02  # least distance of a corner of the board in two views, relative to the image's width
_MARGIN = 0.25  # size of the corners of the image that must be covered, relative to it
_TILT, _TILTED_VIEWS = 0.26, 3  # |sin| of a tilt by 15 degrees; least number of views with it
_FOCAL_SIGMA = 0.004  # relative standard deviation of the focal length that is good enough


def select_views(corners: Array, views: Sequence[BoardView], width: int) -> list[int]:
    """Return the indices of the views whose boards differ most in the image, which is ``width`` px wide."""
    outer = np.array([corners[[0, -1, 0, -1], [0, 0, 0, 0]], corners[[0, 0, -1, -1], [1, 1, 1, 1]]]).T[None]
    outlines = np.array(
        [
            cv2.perspectiveTransform(outer, cv2.findHomography(corners[view.ids, :2], view.pixels)[0]) / width
            for view in views
        ]
    )
    distance, chosen = np.full(len(views), np.inf), list[int]()
    while len(chosen) < min(VIEWS_MAX, len(views)) and distance.max() > _DIFFERENCE_MIN:
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.abs(outlines - outlines[chosen[-1]]).max(axis=(1, 2, 3)))
    return sorted(chosen)


def advice(lens: Calibration, views: Sequence[BoardView]) -> list[str]:
    """Return what the used views of a lens lack, one sentence each; empty if nothing."""
    camera, sentences = lens.cameras[0], []
    places = np.concatenate([views[k].pixels for k in lens.used]) / (camera.width, camera.height)
    for side, x in (('left', 0.0), ('right', 1.0)):
        for end, y in (('upper', 0.0), ('lower', 1.0)):
            if not (np.abs(places - (x, y)).max(axis=1) < _MARGIN).any():
                sentences.append(
                    f'Hold the board into the {end} {side} corner of the image: no view covers it.'
                )
    for axis, count in zip(
        ('sideways', 'up and down'), (np.abs(lens.tilts) > _TILT).sum(axis=0), strict=True
    ):
        if count < _TILTED_VIEWS:
            sentences.append(f'Turn the board {axis} by 20° to 40°: only {count} views show it so.')
    sigma = float((lens.sigmas[:2] / lens.parameters[:2]).max())
    if sigma > _FOCAL_SIGMA:
        sentences.append(
            f'Add near and tilted views: the focal length is only known to {100.0 * sigma:.1f} %.'
        )
    return sentences
