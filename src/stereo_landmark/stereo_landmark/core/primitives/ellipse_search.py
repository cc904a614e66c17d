"""Ellipse detection by hypothesis and verification (the paper's reference 9): arcs propose, edges along them verify."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.arrays import Floats, Ints, Masks
from stereo_landmark.core.primitives.ellipse_fit import fit_ellipse, perimeter

# Smallest turn of an arc that proposes an ellipse alone [rad]; number of points per arc in the fit.
_SINGLE_ARC_TURN_MIN = 1.6
_ARC_SAMPLES = 24
# Largest distance of an inlier edge from the outline in each iteration [px].
_BAND_WIDTHS = (3.0, 2.0, 1.5)
# Required fraction of the final visible fraction in each iteration; smallest cosine between gradient and normal.
_SEEN_RATIOS = (0.7, 0.8, 0.9)
_COSINE_MIN = 0.9
# Largest ratio of the radii of two arcs of an ellipse, and largest distance between them in radii.
_RADII_RATIO_MAX = 6.0
_DISTANCE_MAX = 2.5
# Number of arcs to pair, the longest and most curved ones.
_ARCS_MAX = 250
# Sampling step along the outline [px], and number of samples of the coarse check.
_STEP = 1.5
_COARSE_SAMPLES = 64
# An arc is explained by an ellipse if this fraction of its sampled points is an inlier; number of sampled points.
_EXPLAINED_SAMPLES = 12
_EXPLAINED_FRACTION = 0.6
# Largest rms distance of the inlier edges from the outline [px].
_SCATTER_MAX = 0.7


class EllipseLimits(NamedTuple):
    """Limits of the detection: semi-axes [px], ratio of the axes, visible fraction of the outline."""

    axis_min: float
    axis_max: float
    flatness_min: float
    seen_min: float


@njit(cache=True, error_model='numpy')
def search_ellipses(
    points: Floats, gradients: Floats, index: NDArray[np.int32], spans: Ints, shapes: Floats, limits: EllipseLimits
) -> Floats:
    """Return the verified ellipses, shape (n, 8).

    Args:
        points: edge points of all segments, shape (n, 2) [px].
        gradients: image gradients, which point to the bright side, shape (n, 2).
        index: index of the edge point in each pixel or -1, shape (h, w).
        spans: first and last point of each arc, best arcs first, shape (k, 2).
        shapes: turn [rad] and length [px] of each arc, shape (k, 2).
        limits: limits of axes and visibility.

    Returns:
        centre x, y, semi-axes a, b [px], tilt [rad], polarity, visible fraction, rms distance of edges [px].
    """
    k = min(len(spans), _ARCS_MAX)
    explained = np.zeros(k, np.bool_)
    found = np.empty((k + 1, 8))
    count = 0
    samples = np.empty((2 * _ARC_SAMPLES, 2))
    hypothesis = np.empty(8)
    features, is_compatible = _arc_features(points, spans, shapes, k), np.empty(k, np.bool_)
    for i in range(k):
        _mark_compatible_arcs(features, shapes[i, 0], i, is_compatible)
        # Hypotheses from each arc alone, then from its pairs with the following arcs.
        for j in range(i, k):
            if explained[i]:
                break
            if explained[j] or not is_compatible[j]:
                continue
            size = _sample_arc(points, spans[i], samples, np.int64(0))
            if j > i:
                size = _sample_arc(points, spans[j], samples, size)
            if not fit_ellipse(samples[:size], hypothesis[:5]) or not _is_within_limits(hypothesis, limits):
                continue
            hypothesis[5] = 1.0 if shapes[i, 0] > 0.0 else -1.0
            if _verify(points, gradients, index, hypothesis, limits):
                for m in range(len(hypothesis)):
                    found[count, m] = hypothesis[m]
                count += 1
                for a in range(k):
                    explained[a] |= _explains(points, spans[a], hypothesis)
    return found[:count].copy()


@njit(cache=True, error_model='numpy')
def _arc_features(points: Floats, spans: Ints, shapes: Floats, k: int) -> Floats:
    """Return start, middle, end, direction of the concave side, radius and turn of each arc, shape (10, k)."""
    features = np.empty((10, k))
    for i in range(k):
        first, last = spans[i]
        for m in range(3):
            features[2 * m, i], features[2 * m + 1, i] = points[first + (last - first) * m // 2]
        # An arc that turns to the right is concave on its right side.
        side = 1.0 if shapes[i, 0] > 0.0 else -1.0
        features[6, i] = -side * (features[5, i] - features[1, i])
        features[7, i] = side * (features[4, i] - features[0, i])
        features[8, i], features[9, i] = shapes[i, 1] / abs(shapes[i, 0]), shapes[i, 0]
    return features


@njit(cache=True, error_model='numpy')
def _mark_compatible_arcs(features: Floats, turn: float, i: int, is_compatible: Masks) -> None:
    """Write which arcs can be on the same ellipse as arc i: same sense, each on the concave side of the other.

    Entry i: whether arc i is curved enough to propose an ellipse alone.
    """
    radii, turns = features[8], features[9]
    for j in range(len(is_compatible)):
        # No branches, so that the compiler can vectorize the loop.
        radius = max(radii[j], radii[i])
        compatible = (turns[j] * turn > 0.0) & (radius <= _RADII_RATIO_MAX * min(radii[j], radii[i]))
        squared_limit = (_DISTANCE_MAX * radius) ** 2
        for m in range(3):
            dx, dy = features[2 * m, j] - features[2, i], features[2 * m + 1, j] - features[3, i]
            compatible &= (dx * features[6, i] + dy * features[7, i] >= 0.0) & (dx * dx + dy * dy <= squared_limit)
            dx, dy = features[2 * m, i] - features[2, j], features[2 * m + 1, i] - features[3, j]
            compatible &= (dx * features[6, j] + dy * features[7, j] >= 0.0) & (dx * dx + dy * dy <= squared_limit)
        is_compatible[j] = compatible
    is_compatible[i] = abs(turn) > _SINGLE_ARC_TURN_MIN


@njit(cache=True, error_model='numpy')
def _sample_arc(points: Floats, span: Ints, samples: Floats, size: int) -> int:
    count = min(_ARC_SAMPLES, span[1] - span[0] + 1)
    for s in range(count):
        k = span[0] + (span[1] - span[0]) * s // (count - 1)
        samples[size + s, 0], samples[size + s, 1] = points[k, 0], points[k, 1]
    return size + count


@njit(cache=True, error_model='numpy')
def _is_within_limits(ellipse: Floats, limits: EllipseLimits) -> bool:
    a, b = ellipse[2], ellipse[3]
    return b >= limits.axis_min and a <= limits.axis_max and b >= limits.flatness_min * a


@njit(cache=True, error_model='numpy')
def _verify(
    points: Floats, gradients: Floats, index: NDArray[np.int32], ellipse: Floats, limits: EllipseLimits
) -> bool:
    """Verify a hypothesis: fit it iteratively to the edges along it; write the visible fraction and rms distance."""
    # Most hypotheses are wrong; a few samples of the outline suffice to reject them.
    coarse_step = max(_STEP, perimeter(ellipse[2], ellipse[3]) / _COARSE_SAMPLES)
    if (
        edges_near_outline(points, gradients, index, ellipse, _BAND_WIDTHS[0], coarse_step)[1]
        < _SEEN_RATIOS[0] * limits.seen_min
    ):
        return False
    for k in range(len(_BAND_WIDTHS)):
        inliers, seen, scatter = edges_near_outline(points, gradients, index, ellipse, _BAND_WIDTHS[k], _STEP)
        if seen < _SEEN_RATIOS[k] * limits.seen_min or len(inliers) < 8:
            return False
        ellipse[6], ellipse[7] = seen, scatter
        if not fit_ellipse(points[inliers], ellipse[:5]) or not _is_within_limits(ellipse, limits):
            return False
    _, seen, scatter = edges_near_outline(points, gradients, index, ellipse, _BAND_WIDTHS[-1], _STEP)
    ellipse[6], ellipse[7] = seen, scatter
    return seen >= limits.seen_min and scatter <= _SCATTER_MAX


@njit(cache=True, error_model='numpy')
def edges_near_outline(
    points: Floats, gradients: Floats, index: NDArray[np.int32], ellipse: Floats, band: float, step: float
) -> tuple[NDArray[np.int32], float, float]:
    """Return the inlier edge points along an outline, its visible fraction, and their rms distance [px].

    Args:
        points: edge points, shape (n, 2) [px].
        gradients: image gradients, which point to the bright side, shape (n, 2).
        index: index of the edge point in each pixel or -1, shape (h, w).
        ellipse: centre x, y, semi-axes [px], tilt [rad], polarity.
        band: largest distance from the outline [px].
        step: sampling step along the outline [px].
    """
    steps = max(8, int(perimeter(ellipse[2], ellipse[3]) / step))
    inliers = np.empty(4 * steps + 64, np.int32)
    count, seen, sample_count, squares, t = 0, 0, 0, 0.0, 0.0
    cos_t, sin_t = 1.0, 0.0
    cx, cy, a, b, tilt = ellipse[:5]
    cos_r, sin_r = np.cos(tilt), np.sin(tilt)
    while t < 2.0 * np.pi and count < len(inliers):
        speed = np.sqrt((a * sin_t) ** 2 + (b * cos_t) ** 2)
        x, y = cx + cos_r * a * cos_t - sin_r * b * sin_t, cy + sin_r * a * cos_t + cos_r * b * sin_t
        nx, ny = ((cos_r * b * cos_t - sin_r * a * sin_t) / speed, (sin_r * b * cos_t + cos_r * a * sin_t) / speed)
        # The small rotation avoids trigonometric functions.
        turn = step / speed
        squared = turn * turn
        cos = 1.0 - squared * (1.0 / 2.0 - squared * (1.0 / 24.0 - squared / 720.0))
        sin = turn * (1.0 - squared * (1.0 / 6.0 - squared * (1.0 / 120.0 - squared / 5040.0)))
        cos_t, sin_t, t = cos * cos_t - sin * sin_t, cos * sin_t + sin * cos_t, t + turn
        sample_count += 1
        j, distance = _nearest_edge(points, gradients, index, x, y, nx, ny, ellipse[5], band)
        if j >= 0:
            seen += 1
            squares += distance * distance
            if count == 0 or inliers[count - 1] != j:
                inliers[count] = j
                count += 1
    return inliers[:count], seen / max(sample_count, 1), np.sqrt(squares / max(seen, 1))


@njit(cache=True, error_model='numpy')
def _nearest_edge(
    points: Floats,
    gradients: Floats,
    index: NDArray[np.int32],
    x: float,
    y: float,
    nx: float,
    ny: float,
    polarity: float,
    band: float,
) -> tuple[int, float]:
    """Return the nearest edge along the normal with a matching gradient, -1 for none, and its distance [px]."""
    best, least = -1, band
    for o in range(-int(band), int(band) + 1):
        u, v = int(np.rint(x + o * nx)), int(np.rint(y + o * ny))
        if u < 0 or v < 0 or v >= index.shape[0] or u >= index.shape[1] or index[v, u] < 0:
            continue
        j = index[v, u]
        gx, gy = gradients[j]
        if -polarity * (gx * nx + gy * ny) < _COSINE_MIN * np.sqrt(gx * gx + gy * gy):
            continue
        distance = (points[j, 0] - x) * nx + (points[j, 1] - y) * ny
        if abs(distance) < least:
            best, least = j, abs(distance)
    return best, least


@njit(cache=True, error_model='numpy')
def _explains(points: Floats, span: Ints, ellipse: Floats) -> bool:
    """Return whether most points of an arc are on the ellipse."""
    cos_r, sin_r = np.cos(ellipse[4]), np.sin(ellipse[4])
    inliers, total = 0, 0
    for i in range(span[0], span[1] + 1, max(1, (span[1] - span[0]) // _EXPLAINED_SAMPLES)):
        dx, dy = points[i, 0] - ellipse[0], points[i, 1] - ellipse[1]
        u, v = (cos_r * dx + sin_r * dy) / ellipse[2], (-sin_r * dx + cos_r * dy) / ellipse[3]
        level = np.sqrt(u * u + v * v)
        slope = np.sqrt((u / ellipse[2]) ** 2 + (v / ellipse[3]) ** 2) / max(level, 1e-9)
        inliers += abs(level - 1.0) < _BAND_WIDTHS[-1] * slope
        total += 1
    return inliers >= _EXPLAINED_FRACTION * total
