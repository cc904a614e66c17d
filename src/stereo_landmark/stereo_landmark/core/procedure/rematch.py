"""Which primitives a fitted pose tells to be those of a target.

A supposition takes what lies nearest to a window's middle, and where outlines lie within or beside each other, as on a
panel, that is often another one. The fitted pose tells where each point is to be, in both images and to a few pixels.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.primitives.ellipse import Ellipse
from stereo_landmark.core.procedure.detected_scene import DetectedKind
from stereo_landmark.core.procedure.prediction import expected_pixels
from stereo_landmark.core.procedure.primitive import Primitive, as_ordered, size_of
from stereo_landmark.core.procedure.stereo_measurement import NamedPair, invariant_points
from stereo_landmark.core.procedure.stereo_view import StereoView
from stereo_landmark.core.procedure.taught_place import TaughtPlace, TaughtPrimitive, TaughtTarget

LENGTH_MAX = 1.5
"""Outlines differ less than this times the window at any of their points."""


class Rematch:
    """Matches one target again.

    Args:
        place: as taught.
        target: of the place.
        view: both images.
    """

    def __init__(self, place: TaughtPlace, target: TaughtTarget, view: StereoView) -> None:
        self._target, self._view = target, view
        self._points = [
            place.coordinates.selected(
                tuple(f'{target.name}/{taught.name}/{point}' for point in invariant_points(taught.shape))
            ).positions
            for taught in target.primitives
        ]
        self._depths = [self._depth(taught, np.zeros(4)) for taught in target.primitives]

    def pairs(self, state: NDArray[np.float64], window: float) -> list[NamedPair]:
        """Return the primitives of both images whose points are nearest to where they are expected.

        Args:
            state: shape (4,), x, y, z [m] and yaw [rad] of the robot in the place's frame.
            window: what is farther off at some point is another one [px].
        """
        pairs: list[NamedPair] = []
        for taught, points, depth in zip(self._target.primitives, self._points, self._depths, strict=True):
            pixels = expected_pixels(state[None], points, self._view)[0]
            if np.isnan(pixels).any():
                continue
            size = taught.size * depth / self._depth(taught, state)
            here, there = self._view.both(taught.kind)
            left = _nearest(taught, here, pixels[:, :2], size, window)
            right = _nearest(taught, there, pixels[:, 2:], size, window)
            if left is not None and right is not None:
                pairs.append((f'{self._target.name}/{taught.name}', left, right))
        return pairs

    def _depth(self, taught: TaughtPrimitive, state: NDArray[np.float64]) -> float:
        pixels = expected_pixels(state[None], taught.position[None], self._view)[0, 0]
        rig = self._view.rig
        return rig.left.fx * rig.baseline / float((pixels[0] - rig.left.cx) - (pixels[2] - rig.right.cx))


def _nearest(
    taught: TaughtPrimitive,
    among: DetectedKind,
    expected: NDArray[np.float64],
    size: float,
    window: float,
) -> Primitive | None:
    """Return the primitive of an image that is nearest to expected points, shape (p, 2), with the points so named."""
    if not among.primitives:
        return None
    best, least = None, window
    for i in among.tree.query_ball_point(expected.mean(axis=0), LENGTH_MAX * window):
        found = as_ordered(among.primitives[i], taught.shape)
        seen = found.image_points()
        places = np.array([seen[point].position for point in invariant_points(found)])
        misfit = float(np.hypot(*(places - expected).T).max())
        if isinstance(found, Ellipse):
            misfit = max(misfit, abs(size_of(found) - size))
        if misfit < least:
            best, least = found, misfit
    return best
