"""Primitives of drawn shapes against the truth and the Cramér-Rao bound, beside OpenCV's ellipse fit and LSD.

Dark shapes are rendered with exact areas and a Gaussian blur, at random positions, tilts and axis ratios. Found is what
is detected within 3 px and refined, with the default settings (threshold 2 instead of 6 if the contrast is below 30).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import cv2
import numpy as np
from _figures import rate, rms
from _harness import Option, Run, progress, run_benchmark
from _primitive_pictures import (
    Condition,
    Picture,
    contour_centre,
    ellipse_picture,
    lsd_corners,
    quadrilateral_picture,
)
from numpy.typing import NDArray

from stereo_landmark.core.edges.edges import extract_edges
from stereo_landmark.core.edges.settings import EdgeSettings
from stereo_landmark.core.primitives.ellipse import detect_ellipses, refine_ellipse
from stereo_landmark.core.primitives.line_segments import fit_line_segments
from stereo_landmark.core.primitives.quadrilateral import detect_quadrilaterals, refine_quadrilateral
from stereo_landmark.core.primitives.settings import PrimitiveSettings
from stereo_landmark.core.segments.segments import trace_segments

CONDITIONS = (
    Condition(),
    *(Condition(size=size) for size in (8.0, 12.0, 40.0, 80.0)),
    *(Condition(contrast=contrast) for contrast in (10.0, 20.0, 40.0, 140.0)),
    *(Condition(noise=noise) for noise in (0.3, 1.0, 4.0, 8.0)),
    *(Condition(blur=blur) for blur in (0.0, 0.4, 1.2, 2.0, 3.0)),
)
NEAR = 3.0
"""A primitive whose coordinates are so near to the truth is found [px]."""
_PRIMITIVES = PrimitiveSettings()


class Found(NamedTuple):
    """Coordinates before and after refinement, shape (n,) [px], and their covariance, shape (n, n)."""

    detected: NDArray[np.float64]
    refined: NDArray[np.float64]
    covariance: NDArray[np.float64]


def find_ellipse(picture: Picture, settings: EdgeSettings) -> Found | None:
    """Return the centre of the ellipse near the truth."""
    segments = trace_segments(extract_edges(picture.image, settings), settings)
    for ellipse in detect_ellipses(segments, _PRIMITIVES):
        refined = refine_ellipse(ellipse, picture.image)
        if np.hypot(*(ellipse.centre - picture.truth)) < NEAR and refined is not None:
            return Found(ellipse.centre, refined.centre, refined.covariance[:2, :2])
    return None


def find_quadrilateral(picture: Picture, settings: EdgeSettings) -> Found | None:
    """Return the corners of the quadrilateral near the truth, in its order."""
    segments = trace_segments(extract_edges(picture.image, settings), settings)
    for found in detect_quadrilaterals(fit_line_segments(segments, _PRIMITIVES), _PRIMITIVES):
        turned = (found.rotate_corners(k) for k in range(4))
        nearest = min(turned, key=lambda q: float(np.abs(q.corners.ravel() - picture.truth).max()))
        refined = refine_quadrilateral(nearest, picture.image)
        if np.abs(nearest.corners.ravel() - picture.truth).max() < NEAR and refined is not None:
            return Found(nearest.corners.ravel(), refined.corners.ravel(), refined.covariance)
    return None


SHAPES: dict[
    str, tuple[str, Callable[..., Picture], Callable[..., Found | None], Callable[[Picture], object]]
] = {
    'Centre of an ellipse': (
        'cv2.fitEllipseDirect',
        ellipse_picture,
        find_ellipse,
        lambda picture: contour_centre(picture.image),
    ),
    'Corners of a quadrilateral': (
        'cv2 LSD',
        quadrilateral_picture,
        find_quadrilateral,
        lambda picture: lsd_corners(picture.image, picture.truth),
    ),
}
"""Name of the peer, what draws a picture, what finds the shape, and the peer."""


def whitened(found: Sequence[tuple[Found, Picture]]) -> list[NDArray[np.float64]]:
    """Return errors by the stated covariance: normal deviates if it is true."""
    return [np.linalg.solve(np.linalg.cholesky(f.covariance), f.refined - p.truth) for f, p in found]


def main(run: Run, pictures: int) -> None:
    """Find the shapes in pictures of each condition."""
    cv2.setNumThreads(1)
    heads = 'found', 'error px: rms', 'error / sigma', 'rms over the bound', 'before refinement px'
    for title, (peer_name, draw, find, ask_peer) in SHAPES.items():
        peer_heads = f'{peer_name}: found', 'error px: rms'
        table = run.table(title, 'size px', 'contrast', 'noise', 'blur px', *heads, *peer_heads)
        for condition in progress(CONDITIONS, title):
            # What a person would teach for the place: edges above the noise.
            settings = EdgeSettings(threshold=2.0 if condition.contrast < 30.0 else 6.0)
            drawn = [draw(condition, seed) for seed in range(pictures)]
            found = [(shape, p) for p in drawn if (shape := find(p, settings)) is not None]
            answers = [(np.asarray(answer), p) for p in drawn if (answer := ask_peer(p)) is not None]
            peer = [answer - p.truth for answer, p in answers if np.abs(answer - p.truth).max() < NEAR]
            bound = math.sqrt(np.mean([p.bound for p in drawn]))
            errors = [shape.refined - p.truth for shape, p in found]
            table.add(
                *(
                    f'{value:g}'
                    for value in (condition.size, condition.contrast, condition.noise, condition.blur)
                ),
                *(rate(len(found), pictures), rms(errors, '.4f'), rms(whitened(found), '.2f', better='one')),
                *(rms(np.array(errors) / bound, '.2f'), rms([s.detected - p.truth for s, p in found], '.4f')),
                *(rate(len(peer), pictures, ''), rms(peer, '.4f', better='')),
            )


if __name__ == '__main__':
    run_benchmark(main, pictures=Option(40, 2, 'of each condition'))
