"""Which dot of an image is which dot of a mat, when neither height nor tilt of the camera is known.

The dots' size tells the scale: the printed diameter over the diameter in the image. The image is rectified for a
few tilts around the supposed one; under the right one its dots match the mat by a similarity.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.detected_dots import DetectedDots
from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.survey.dot_matching import DotField, Matched, Tolerances
from shirube_geometry import CameraMount, PinholeCamera, matrix_from_rpy

# Tilts to try about both axes [rad]: in between, the rest of the tilt bends the view by less than dots are apart.
_TILTS = tuple(math.radians(degrees) for degrees in (0.0, -5.0, 5.0, -10.0, 10.0, -15.0, 15.0))
_SCALE = 0.12
"""The dots' size may tell the scale so badly: ink spreads, edges blur."""
_SIGMA = 0.0004
_CHANCE = 1e-6
_ENOUGH = 0.8
"""No better tilt is looked for when this share of the dots matches."""


def match_mat(
    dots: DetectedDots, camera: PinholeCamera, mat: DotMap, supposed: CameraMount
) -> tuple[NDArray[np.int64], NDArray[np.int64]] | None:
    """Return the indices of the matched dots of the image and of those of the mat.

    None where no tilt within 15 degrees of the supposed one makes them match.
    """
    field = DotField(mat.points)
    height = (
        float(np.median(mat.diameters)) * math.sqrt(camera.fx * camera.fy) / float(np.median(dots.diameters))
    )
    rays = camera.rays_from_pixels(dots.pixels)
    by = Tolerances(_SIGMA, _SCALE, math.radians(2.5) / height, _CHANCE)
    best: Matched | None = None
    for roll, pitch in sorted(itertools.product(_TILTS, _TILTS), key=lambda tilt: math.hypot(*tilt)):
        rotation = matrix_from_rpy((roll, pitch, 0.0)) @ supposed.rotation
        directions = rays @ rotation.T
        if (directions[:, 2] > -0.2).any():
            continue
        points = -height * directions[:, :2] / directions[:, 2:]
        found = field.match_anywhere(points - points.mean(axis=0), by)
        if found is not None and (best is None or len(found.laid) > len(best.laid)):
            best = found
            if len(found.laid) > _ENOUGH * len(dots):
                break
    return None if best is None else (best.laid, best.under)
