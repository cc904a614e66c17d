"""Fit straight lines to the four edges of a frame, finer than a pixel."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from card_edge import fit_card_edge
from numpy.typing import NDArray

Array = NDArray[np.float64]

REACHES = (6.0, 4.0, 4.0)  # of the profiles across an edge to either side, step by step [px]
STEP = 0.25  # of the profiles [px]
TRIM = 0.06  # share of a side left out at either end
CHUNKS = 16  # pieces of a side whose profiles are averaged
FIRST_EDGE = 0.35  # least steepness of the page's edge, relative to the steepest in the profile
FAINTEST_EDGE = 0.04  # per pixel, relative to the page's brightness
STRAY = 3.5  # a fitted line's distance from the first guess at either end [px]
ON_LINE = 0.5  # distance from the line of what belongs to it [px]


@dataclass(frozen=True)
class RefinedQuad:
    """A quadrilateral whose corners are the intersections of fitted edges.

    Attributes:
        corners: shape (4, 2) [px], clockwise as seen in the image.
        is_printed: whether all edges are thin dark lines; the corners are then those of the lines' middles.
    """

    corners: Array
    is_printed: bool


@dataclass(frozen=True)
class _Side:
    edge: Array  # (a, b, c) of the line where the page's brightness ends
    middle: Array | None  # (a, b, c) of the middle of a thin dark line, None where it is none


def refine_quad(image: NDArray[np.uint8], quad: Array) -> RefinedQuad | None:
    """Return the quadrilateral fitted to the image's edges, None where a side has too little edge to fit.

    Args:
        image: grey, undistorted.
        quad: shape (4, 2), clockwise as seen in the image, good to a few pixels.
    """
    corners = quad
    is_printed = False
    for reach in REACHES:
        sides = [_fit_side(image, corners[i], corners[(i + 1) % 4], reach) for i in range(4)]
        edges = [side.edge for side in sides if side is not None]
        middles = [side.middle for side in sides if side is not None and side.middle is not None]
        if len(edges) < 4:
            return None
        is_printed = len(middles) == 4
        lines = middles if is_printed else edges
        corners = np.array([_intersection(lines[i - 1], lines[i]) for i in range(4)])
    return RefinedQuad(corners, is_printed)


def card_corners(image: NDArray[np.uint8], corners: Array) -> Array:
    """Return the corners of a card's upper face, shape (4, 2) [px], from those of its outline good to a few pixels."""
    lines = [_card_side(image, corners[i], corners[(i + 1) % 4]) for i in range(4)]
    return np.array([_intersection(lines[i - 1], lines[i]) for i in range(4)])


def _intersection(first: Array, second: Array) -> Array:
    point = np.cross(first, second)
    return point[:2] / point[2]


def _fit_side(image: NDArray[np.uint8], start: Array, end: Array, reach: float) -> _Side | None:
    depth = np.arange(-reach, reach + 5.0, STEP)
    profiles, places, outward = _profiles(image, start, end, depth)
    found = np.array([_edges_in_profile(profile, depth, reach) for profile in profiles])
    edge = _line_through(places + found[:, :1] * outward, start, end)
    if edge is None:
        return None
    middle = None
    if np.isfinite(found[edge[1], 1]).mean() > 0.7:
        middle = _line_through(places + found[:, 1:] * outward, start, end)
    return _Side(edge[0], None if middle is None else middle[0])


def _profiles(image: NDArray[np.uint8], start: Array, end: Array, depth: Array) -> tuple[Array, Array, Array]:
    """Return the brightness across a side, (chunks, m), the chunks' middles (chunks, 2) and the way out (2,)."""
    along = (end - start) / np.linalg.norm(end - start)
    outward = np.array([along[1], -along[0]])
    share = TRIM + (1.0 - 2.0 * TRIM) * (np.arange(8 * CHUNKS) + 0.5) / (8 * CHUNKS)
    points = start + share[:, None] * (end - start)
    grid = (points[:, None] + depth[None, :, None] * outward).astype(np.float32)
    levels = cv2.remap(image, grid[..., 0], grid[..., 1], cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    profiles = np.median(levels.reshape(CHUNKS, 8, -1).astype(np.float64), axis=1)
    return profiles, points.reshape(CHUNKS, 8, 2).mean(axis=1), outward


def _card_side(image: NDArray[np.uint8], start: Array, end: Array) -> Array:
    """Return the line of a card's upper edge; the one through start and end where too little of it is seen."""
    depth = np.arange(-4.0, 7.01, 0.5)
    profiles, _, outward = _profiles(image, start, end, depth)
    offsets = fit_card_edge(profiles, depth)
    if offsets is None:
        return _line(np.stack([start, end]))
    first, last = start + TRIM * (end - start), end - TRIM * (end - start)
    return _line(np.stack([first + offsets[0] * outward, last + offsets[1] * outward]))


def _edges_in_profile(profile: Array, depth: Array, reach: float) -> tuple[float, float]:
    """Return where a profile from the page outwards leaves the page, and the middle of the thin line there [px].

    NaN means that there is no edge, and for the middle where it is dark behind the edge.
    """
    nothing = (np.nan, np.nan)
    smooth = cv2.GaussianBlur(profile[None], (0, 0), 0.4 / STEP)[0]
    slope = np.where(np.abs(depth) <= reach, -np.gradient(smooth, STEP), 0.0)
    inside = float(np.median(profile[depth < -reach / 2.0]))
    if slope.max() < FAINTEST_EDGE * inside:
        return nothing
    steep = (slope[1:-1] >= slope[:-2]) & (slope[1:-1] > slope[2:]) & (slope[1:-1] > FIRST_EDGE * slope.max())
    peaks = np.nonzero(steep)[0] + 1
    if len(peaks) == 0:
        return nothing
    k = int(peaks[0])
    a, b, c = slope[k - 1 : k + 2]
    edge = float(depth[k] + STEP * 0.5 * (a - c) / (a - 2.0 * b + c))
    behind = (depth > edge + 1.5) & (depth < edge + 4.5)
    if profile[behind].max() < 0.92 * inside:
        return edge, np.nan
    near = (depth > edge - 1.0) & (depth < edge + 2.5)
    dark = np.clip(0.97 * inside - profile[near], 0.0, None)
    return edge, float(np.average(depth[near], weights=dark + 1e-9))


def _line_through(points: Array, start: Array, end: Array) -> tuple[Array, NDArray[np.int64]] | None:
    """Return the line (a, b, c), a² + b² = 1, that most points lie on near a first guess, and which points do."""
    usable = np.nonzero(np.isfinite(points).all(axis=1))[0]
    best = usable[:0]
    for i in usable:
        for j in usable[usable > i]:
            line = _line(points[[i, j]])
            ends = np.abs(np.stack([start, end]) @ line[:2] + line[2])
            near = usable[np.abs(points[usable] @ line[:2] + line[2]) < ON_LINE]
            if ends.max() < STRAY and len(near) > len(best):
                best = near
    if len(best) < 3:
        return None
    return _line(points[best]), best


def _line(points: Array) -> Array:
    centre = points.mean(axis=0)
    normal = np.linalg.svd(points - centre)[2][1]
    return np.array([*normal, -normal @ centre])
