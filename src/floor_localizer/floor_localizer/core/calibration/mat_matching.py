"""Match the dots of an image to those of a mat when neither height nor tilt of the camera is known.

The scale is the printed diameter of the dots over their diameter in the image. The image is rectified for a grid of
tilts around the initial one; for the right tilt its dots match the mat by a similarity.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.detected_dots import DetectedDots
from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.survey.dot_matching import DotMatch, DotMatcher, Tolerances
from shirube_core.geometry import CameraMount, PinholeCamera, matrix_from_rpy

# Tilts to try about both axes [rad]; the error from tilts in between is smaller than the dot spacing.
_TILTS = tuple(math.radians(degrees) for degrees in (0.0, -5.0, 5.0, -10.0, 10.0, -15.0, 15.0))
_SCALE_TOLERANCE = 0.12
"""Relative error of the scale estimated from dot diameters, as ink spreads and edges blur."""
_SIGMA = 0.0004
_CHANCE_ALIGNMENTS_MAX = 1e-6
_STOP_FRACTION = 0.8
"""Fraction of matched dots at which the search over tilts stops."""


def match_mat(
    dots: DetectedDots, camera: PinholeCamera, mat: DotMap, initial_mount: CameraMount
) -> tuple[NDArray[np.int64], NDArray[np.int64]] | None:
    """Return the indices of the matched dots in the image and in the mat.

    None if they match at no tilt within 15 degrees of the initial mount.
    """
    matcher = DotMatcher(mat.points)
    height = (
        float(np.median(mat.diameters)) * math.sqrt(camera.fx * camera.fy) / float(np.median(dots.diameters))
    )
    rays = camera.rays_from_pixels(dots.pixels)
    tolerances = Tolerances(_SIGMA, _SCALE_TOLERANCE, math.radians(2.5) / height, _CHANCE_ALIGNMENTS_MAX)
    best: DotMatch | None = None
    for roll, pitch in sorted(itertools.product(_TILTS, _TILTS), key=lambda tilt: math.hypot(*tilt)):
        rotation = matrix_from_rpy((roll, pitch, 0.0)) @ initial_mount.rotation
        directions = rays @ rotation.T
        if (directions[:, 2] > -0.2).any():
            continue
        points = -height * directions[:, :2] / directions[:, 2:]
        found = matcher.match_anywhere(points - points.mean(axis=0), tolerances)
        if found is not None and (best is None or len(found.source) > len(best.source)):
            best = found
            if len(found.source) > _STOP_FRACTION * len(dots):
                break
    return None if best is None else (best.source, best.target)
