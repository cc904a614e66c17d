"""Find the bright quadrilateral frames of printed pages in a photograph, by their edges alone.

A frame is a closed chain of four corners. A corner is where two edges meet, both with the bright page on the
same side; between two corners an edge may be hidden by a hand or a stick, as long as its seen pieces lie on one
line. The dots inside take no part but for their number, so that a frame's pose is independent of its dots.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import cv2
import numpy as np
from edge_lines import card_corners, refine_quad
from numpy.typing import NDArray
from page_dots import find_page_dots

Array = NDArray[np.float64]

ENLARGEMENT = 2  # of the image, for short pieces of edges and for thin lines
SEGMENT_MIN = 5.0  # length of an edge piece [px]
INSIDE = 2.5  # from an edge to where the page's brightness is taken [px]
ON_LINE = 1.2  # distance from an edge piece's line of what continues it [px]
GROWTH_GAP = 30.0  # between two pieces that are one edge [px]
CORNER_GAP = 8.0  # from an edge piece's end to the corner [px] ...
CORNER_FRACTION = 0.25  # ... or as a share of the piece's length
SAME_CORNER = 1.5  # [px]
SAME_DIRECTION = 0.15  # [rad]
STRAIGHTNESS = 3.0  # distance of an edge piece from its side's chord [px]
MINIMUM_SIDE = 40.0  # [px]
BRIGHTNESS = 0.65  # of a page, relative to the brightest hundredth of the image
ASPECTS = (0.9, 1.0, 1.11)  # of the rectangles that a frame may be
MISFIT = 0.013  # root mean square distance from such a rectangle's image, relative to the side
REFINEMENT = 4.0  # greatest, of a corner [px]
WHITE_FRACTION = 0.6  # least, of a frame's inside
MUCH_LARGER = 1.12  # ratio of areas
BLACK = 2.0  # grey level where undistortion has no picture
MINIMUM_DOTS = 12  # seen inside a frame


@dataclass(frozen=True)
class FoundFrame:
    """A page's frame in an undistorted image.

    Attributes:
        corners: shape (4, 2), clockwise as seen in the image [px].
        is_printed: whether the frame is a printed line; else it is the edge of the page.
        dots: number of dots seen inside.
    """

    corners: Array
    is_printed: bool
    dots: int


@dataclass(frozen=True)
class _Corners:
    points: Array  # (n, 2)
    before: NDArray[np.int64]  # (n,) edge piece that comes in
    after: NDArray[np.int64]  # (n,) edge piece that goes out


def find_frames(image: NDArray[np.uint8], camera_matrix: Array) -> list[FoundFrame]:
    """Return the frames in an undistorted grey image, taken by a camera with the matrix given, shape (3, 3)."""
    segments = _edge_segments(image)
    corners = _corners(segments)
    dots = find_page_dots(image)
    found: list[FoundFrame] = []
    for quad in _chains(corners, segments):
        inside = _count_inside(quad, dots)
        if inside < MINIMUM_DOTS:
            continue
        refined = refine_quad(image, quad)
        if refined is None or np.abs(refined.corners - quad).max() > REFINEMENT:
            continue
        if (
            _is_squarish(refined.corners, camera_matrix)
            and _white_fraction(image, refined.corners) > WHITE_FRACTION
        ):
            found.append(FoundFrame(refined.corners, refined.is_printed, inside))
    return [
        frame if frame.is_printed else replace(frame, corners=card_corners(image, frame.corners))
        for frame in _without_nested(found)
    ]


def _edge_segments(image: NDArray[np.uint8]) -> Array:
    """Return straight edge pieces, shape (n, 2, 2): start and end [px], with the bright side to the right."""
    large = cv2.resize(image, None, fx=ENLARGEMENT, fy=ENLARGEMENT, interpolation=cv2.INTER_CUBIC)
    lines = cv2.createLineSegmentDetector().detect(large)[0]
    if lines is None:
        return np.empty((0, 2, 2))
    segments = (lines.reshape(-1, 2, 2).astype(np.float64) + 0.5) / ENLARGEMENT - 0.5
    segments = segments[_lengths(segments) >= SEGMENT_MIN]
    normal = _normals(_directions(segments))
    turn = _mean_along(image, segments, -normal) > _mean_along(image, segments, normal)
    segments[turn] = segments[turn][:, ::-1]
    normal[turn] *= -1.0
    white = BRIGHTNESS * np.percentile(image, 99.0)
    is_page = _mean_along(image, segments, INSIDE * normal) > white
    is_border = _mean_along(image, segments, -INSIDE * normal) < BLACK
    segments = segments[is_page & ~is_border]
    return np.concatenate([segments, *[_extend(segment, segments)[None] for segment in segments]])


def _lengths(segments: Array) -> Array:
    return np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)


def _directions(segments: Array) -> Array:
    return (segments[:, 1] - segments[:, 0]) / _lengths(segments)[:, None]


def _extend(segment: Array, segments: Array) -> Array:
    """Return a piece lengthened by those that lie on its line, over small gaps."""
    directions = _directions(segments)
    for forward in (True, False, True, False):
        while True:
            along = (segment[1] - segment[0]) / np.linalg.norm(segment[1] - segment[0])
            across = np.array([-along[1], along[0]])
            on_line = (np.abs((segments - segment[0]) @ across) < ON_LINE).all(axis=1) & (
                directions @ along > 0.98
            )
            gap = (segments[:, 0] - segment[1]) @ along if forward else (segment[0] - segments[:, 1]) @ along
            usable = np.nonzero(on_line & (gap > -3.0) & (gap < GROWTH_GAP))[0]
            if len(usable) == 0:
                break
            other = segments[usable[np.argmin(gap[usable])]]
            segment = np.array([segment[0], other[1]] if forward else [other[0], segment[1]])
    return segment


def _mean_along(image: NDArray[np.uint8], segments: Array, offset: Array) -> Array:
    """Return the mean grey level along pieces moved by an offset, shape (n,)."""
    share = np.linspace(0.1, 0.9, 9)
    points = segments[:, :1] + share[None, :, None] * (segments[:, 1:] - segments[:, :1]) + offset[:, None]
    maps = points.astype(np.float32)
    values = cv2.remap(image, maps[..., 0], maps[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return values.reshape(len(segments), -1).astype(np.float64).mean(axis=1)


def _corners(segments: Array) -> _Corners:
    """Return where an edge piece ends and another begins with a turn to the right."""
    start, end = segments[:, 0], segments[:, 1]
    along = _directions(segments)
    reach = np.maximum(CORNER_GAP, CORNER_FRACTION * _lengths(segments))
    near = np.linalg.norm(end[:, None] - start[None], axis=2) < reach[:, None] + reach[None]
    sine = along[:, None, 0] * along[None, :, 1] - along[:, None, 1] * along[None, :, 0]
    before, after = np.nonzero(near & (sine > 0.4))
    gap = start[after] - end[before]
    to_end = (gap[:, 0] * along[after, 1] - gap[:, 1] * along[after, 0]) / sine[before, after]
    points = end[before] + to_end[:, None] * along[before]
    to_start = np.linalg.norm(points - start[after], axis=1)
    good = (np.abs(to_end) < reach[before]) & (to_start < reach[after])
    return _distinct(_Corners(points[good], before[good], after[good]), segments)


def _distinct(corners: _Corners, segments: Array) -> _Corners:
    """Keep one of corners at one place with equal directions, the one with the longest edge pieces."""
    vectors = segments[:, 1] - segments[:, 0]
    length = np.linalg.norm(vectors, axis=1)
    angle = np.arctan2(vectors[:, 1], vectors[:, 0])
    kept: list[int] = []
    for i in np.argsort(-np.minimum(length[corners.before], length[corners.after])):
        near = [k for k in kept if np.linalg.norm(corners.points[k] - corners.points[i]) < SAME_CORNER]
        turns = [
            np.abs(np.angle(np.exp(1j * (angle[side[k]] - angle[side[i]]))))
            for k in near
            for side in (corners.before, corners.after)
        ]
        if not any(max(pair) < SAME_DIRECTION for pair in zip(turns[::2], turns[1::2], strict=True)):
            kept.append(int(i))
    return _Corners(corners.points[kept], corners.before[kept], corners.after[kept])


def _chains(corners: _Corners, segments: Array) -> list[Array]:
    """Return the quadrilaterals that chains of four corners close, each of shape (4, 2)."""
    points = corners.points
    follows: list[list[int]] = [[] for _ in points]
    for i in range(len(points)):
        chord = points - points[i]
        length = np.linalg.norm(chord, axis=1)
        with np.errstate(divide='ignore', invalid='ignore'):
            unit = chord / length[:, None]
        out, into = segments[corners.after[i]], segments[corners.before]
        off_out = np.abs(np.einsum('nk,pk->np', _normals(unit), out - points[i]))
        off_into = np.abs(np.einsum('nk,npk->np', _normals(unit), into - points[i]))
        ahead = np.einsum('nk,k->n', unit, out[1] - out[0]) > 0.0
        ahead &= np.einsum('nk,nk->n', unit, into[:, 1] - into[:, 0]) > 0.0
        good = (length > MINIMUM_SIDE) & ahead
        good &= (off_out.max(axis=1) < STRAIGHTNESS) & (off_into.max(axis=1) < STRAIGHTNESS)
        follows[i] = np.nonzero(good)[0].tolist()
    quads = []
    for a in range(len(points)):
        for b, c, d in _paths(follows, a):
            if a < min(b, c, d) and a in follows[d]:
                quads.append(points[[a, b, c, d]])
    return quads


def _is_squarish(corners: Array, camera_matrix: Array) -> bool:
    """Return whether a quadrilateral may be the image of a rectangle that is almost a square."""
    side = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).mean()
    for aspect in ASPECTS:
        half = np.array(
            [[-aspect, -1, 0], [aspect, -1, 0], [aspect, 1, 0], [-aspect, 1, 0]], dtype=np.float64
        )
        _, _, _, errors = cv2.solvePnPGeneric(half, corners, camera_matrix, None, flags=cv2.SOLVEPNP_IPPE)
        if len(errors) > 0 and np.min(errors) < MISFIT * side:
            return True
    return False


def _white_fraction(image: NDArray[np.uint8], corners: Array) -> float:
    inside = np.zeros_like(image)
    cv2.fillConvexPoly(inside, np.round(corners).astype(np.int32), 1)
    return float((image[inside > 0] > BRIGHTNESS * np.percentile(image, 99.0)).mean())


def _paths(follows: list[list[int]], a: int) -> itertools.chain[tuple[int, int, int]]:
    return itertools.chain.from_iterable(
        ((b, c, d) for d in follows[c]) for b in follows[a] for c in follows[b]
    )


def _normals(vectors: Array) -> Array:
    return np.column_stack([-vectors[:, 1], vectors[:, 0]])


def _count_inside(quad: Array, dots: Array) -> int:
    outline = quad.astype(np.float32)
    return sum(cv2.pointPolygonTest(outline, (float(u), float(v)), False) > 0 for u, v in dots)


def _without_nested(frames: list[FoundFrame]) -> list[FoundFrame]:
    """Keep the best one of frames that lie in each other."""
    kept: list[FoundFrame] = []
    for frame in sorted(frames, key=lambda f: _area(f.corners)):
        rivals = [other for other in kept if _overlap(frame, other)]
        if all(_is_better(frame, other) for other in rivals):
            kept = [other for other in kept if not _overlap(frame, other)] + [frame]
    return kept


def _overlap(first: FoundFrame, second: FoundFrame) -> bool:
    centres = first.corners.mean(axis=0)[None], second.corners.mean(axis=0)[None]
    return _count_inside(first.corners, centres[1]) + _count_inside(second.corners, centres[0]) > 0


def _is_better(larger: FoundFrame, smaller: FoundFrame) -> bool:
    """Return whether the larger of two frames is the one to keep.

    A printed line goes before the edge of its paper, more dots before fewer. With equal dots the larger one is
    kept if it is much larger, for a stick cuts pieces off; else it is the side of a card round its upper face.
    """
    if larger.is_printed != smaller.is_printed:
        return larger.is_printed
    if larger.dots != smaller.dots:
        return larger.dots > smaller.dots
    return _area(larger.corners) > MUCH_LARGER * _area(smaller.corners)


def _area(corners: Array) -> float:
    return float(cv2.contourArea(corners.astype(np.float32)))
