"""Parallel lines: pipes, slots, frames (paper 3.3c)."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from shirube_core.settings import setting
from stereo_landmark.core.arrays import Floats, GreyImage
from stereo_landmark.core.primitives.line_refinement import RefinedLine, refine_lines
from stereo_landmark.core.primitives.line_segments import LineSegments
from stereo_landmark.core.primitives.shape import ImagePoint, wrap_differences
from stereo_landmark.core.settings import PrimitiveSettings

# Standard deviation of the ends of a segment along it [px].
_END_SIGMA = 1.0


@dataclass(frozen=True, eq=False)
class ParallelLines:
    """Two parallel lines in an image; angles are counted from x (right) to y (down).

    Attributes:
        width: distance between the lines [px].
        length: length of their overlap, without the rounded corners [px].
        tilt: angle of their common direction, in (-pi/2, pi/2] [rad].
        centre: centre of the overlap, shape (2,) [px].
        polarity: 1 if it is bright between them, -1 if it is dark, 0 for two steps of the same sense.
        covariance: covariance of the centre across the lines, tilt and width, shape (3, 3) [px, rad, px].
        end_sigma: standard deviation of the centre along the lines [px].
    """

    width: float
    length: float
    tilt: float
    centre: Floats
    polarity: int
    covariance: Floats
    end_sigma: float

    @property
    def direction(self) -> Floats:
        """Unit vector along the lines, shape (2,)."""
        return np.array([math.cos(self.tilt), math.sin(self.tilt)])

    @property
    def lines(self) -> Floats:
        """End points of both lines, shape (2, 2, 2) [px]: the one on the side of -normal first."""
        along = 0.5 * self.length * self.direction
        across = 0.5 * self.width * np.array([-self.direction[1], self.direction[0]])
        return np.array([[self.centre + s * across - along, self.centre + s * across + along] for s in (-1.0, 1.0)])

    @property
    def shape_vector(self) -> tuple[float, ...]:
        """Width and length [px], tilt [rad] and polarity."""
        return self.width, self.length, self.tilt, self.polarity

    def outline(self) -> list[Floats]:
        """Return both lines, each of shape (2, 2) [px]."""
        return list(self.lines)

    def image_points(self) -> dict[str, ImagePoint]:
        """Return the candidates for corresponding points, by name; they are accurate across the lines only."""
        along = np.outer(self.direction, self.direction)
        covariance = self.end_sigma**2 * along + self.covariance[0, 0] * (np.eye(2) - along)
        return {'centre': ImagePoint(self.centre, covariance)}


@dataclass(frozen=True)
class ParallelLinesTolerance:
    """Tolerances between detected parallel lines and the taught ones."""

    width: float = setting(0.45, 'relative tolerance of the width', limits=(0.01, 5.0))
    tilt: float = setting(0.25, 'tolerance of the tilt', 'rad', (0.01, 1.6))
    length: float = setting(1.0, 'relative tolerance of the length', limits=(0.01, 10.0))


def parallel_lines_differences(found: Floats, taught: Floats, tolerance: ParallelLinesTolerance) -> Floats:
    """Return the differences of detected, shape (n, 4), from taught shape vectors, (k, 4), shape (k, n)."""
    mine, theirs = found.T[:, None, :], taught.T[:, :, None]
    widths = np.abs(np.log(mine[0] / theirs[0])) / math.log1p(tolerance.width)
    lengths = np.abs(np.log(mine[1] / theirs[1])) / math.log1p(tolerance.length)
    tilts = np.abs(wrap_differences(mine[2] - theirs[2], math.pi)) / tolerance.tilt
    return np.where(mine[3] == theirs[3], np.maximum(np.maximum(widths, lengths), tilts), math.inf)


def detect_parallel_lines(lines: LineSegments, settings: PrimitiveSettings) -> list[ParallelLines]:
    """Detect pairs of parallel, overlapping line segments.

    Returns:
        the pairs, by falling length.
    """
    rows = _find_pairs(
        *(lines.ends, lines.variances, settings.parallel_length_min, settings.parallel_angle_max),
        *(settings.parallel_width_max, settings.parallel_overlap_min),
    )
    cells = np.column_stack([np.rint(rows[:, 3:5] / 3.0), np.rint(rows[:, 0] / 2.0), rows[:, 5]])
    order = np.argsort(-rows[:, 1], kind='stable')
    _, first = np.unique(cells[order], axis=0, return_index=True)
    rows = rows[order[np.sort(first)]]
    covariances = np.zeros((len(rows), 3, 3))
    covariances[:, [0, 1, 2], [0, 1, 2]] = rows[:, [6, 7, 6]] * [0.25, 0.25, 1.0]
    return [
        ParallelLines(width, length, tilt, centre, int(polarity), covariance, _END_SIGMA)
        for (width, length, tilt), centre, polarity, covariance in zip(
            rows[:, :3].tolist(), rows[:, 3:5], rows[:, 5].tolist(), covariances, strict=True
        )
    ]


def refine_parallel_lines(found: ParallelLines, image: GreyImage) -> ParallelLines | None:
    """Refine both lines in the grey image; their ends remain unchanged.

    Args:
        found: detected lines, off by about a pixel at most.
        image: grey image, shape (h, w).

    Returns:
        refined lines, None if the image does not show two straight edges there.
    """
    lines = refine_lines(image, found.lines)
    if lines is None:
        return None
    first, second = lines
    both = first.direction + second.direction
    direction = both / np.hypot(*both)
    normal = np.array([-direction[1], direction[0]])
    rows = [_offset_at_centre(line, found.centre, direction, normal) for line in (first, second)]
    offsets = np.array([row[0] for row in rows])
    variances = np.array([row[1] for row in rows])
    tilt = math.atan2(direction[1], direction[0])
    covariance = np.diag([0.25 * variances.sum(), 0.25 * (first.variances[1] + second.variances[1]), variances.sum()])
    covariance[0, 2] = covariance[2, 0] = 0.5 * (variances[1] - variances[0])
    return replace(
        found,
        width=float(abs(offsets[1] - offsets[0])),
        tilt=math.pi / 2 - math.remainder(math.pi / 2 - tilt, math.pi),
        centre=found.centre + offsets.mean() * normal,
        covariance=covariance,
    )


def _offset_at_centre(line: RefinedLine, centre: Floats, direction: Floats, normal: Floats) -> tuple[float, float]:
    """Return a line's offset from the centre along the normal [px], and its variance [px²]."""
    along = float((centre - line.middle) @ direction) / float(line.direction @ direction)
    offset = float((line.middle + along * line.direction - centre) @ normal)
    return offset, float(line.variances[0] + along**2 * line.variances[1])


@njit(cache=True, error_model='numpy')
def _find_pairs(
    ends: Floats, variances: Floats, length_min: float, angle_max: float, width_max: float, overlap_min: float
) -> Floats:
    """Return width, length, tilt, centre, polarity and summed variances of each pair, shape (n, 8)."""
    steps = ends[:, 1] - ends[:, 0]
    lengths = np.sqrt(steps[:, 0] ** 2 + steps[:, 1] ** 2)
    long = np.flatnonzero(lengths >= length_min)
    tilts = np.arctan2(steps[long, 1], steps[long, 0]) % np.pi
    order = np.argsort(tilts)
    n = len(long)
    rows = np.empty((32 * n + 16, 8))
    count = 0
    for a in range(n):
        i = long[order[a]]
        for b in range(1, n):
            other = order[(a + b) % n]
            if (tilts[other] - tilts[order[a]]) % np.pi > angle_max or count == len(rows):
                break
            j = long[other]
            if _measure_pair(ends, steps, lengths, i, j, width_max, overlap_min, rows[count]):
                rows[count, 6] = variances[i, 0] + variances[j, 0]
                rows[count, 7] = variances[i, 1] + variances[j, 1]
                count += 1
    return rows[:count].copy()


@njit(cache=True, error_model='numpy')
def _measure_pair(
    ends: Floats, steps: Floats, lengths: Floats, i: int, j: int, width_max: float, overlap_min: float, row: Floats
) -> bool:
    # The common direction is that of the sum; offsets are taken at the middle of the overlap.
    same = steps[i, 0] * steps[j, 0] + steps[i, 1] * steps[j, 1] > 0.0
    sign = 1.0 if same else -1.0
    dx, dy = steps[i, 0] + sign * steps[j, 0], steps[i, 1] + sign * steps[j, 1]
    norm = np.sqrt(dx * dx + dy * dy)
    dx, dy = dx / norm, dy / norm
    near_j, far_j = (0, 1) if same else (1, 0)
    begin = max(dx * ends[i, 0, 0] + dy * ends[i, 0, 1], dx * ends[j, near_j, 0] + dy * ends[j, near_j, 1])
    end = min(dx * ends[i, 1, 0] + dy * ends[i, 1, 1], dx * ends[j, far_j, 0] + dy * ends[j, far_j, 1])
    if end - begin < overlap_min * max(lengths[i], lengths[j]):
        return False
    middle = 0.5 * (begin + end)
    offset_i, offset_j = _offset(ends[i], dx, dy, middle), _offset(ends[j], dx, dy, middle)
    width = abs(offset_j - offset_i)
    if width < 2.0 or width > min(width_max, end - begin):
        return False
    across = 0.5 * (offset_i + offset_j)
    tilt = np.arctan2(dy, dx)
    row[0], row[1] = width, end - begin
    row[2] = tilt - np.pi if tilt > 0.5 * np.pi else (tilt + np.pi if tilt <= -0.5 * np.pi else tilt)
    row[3], row[4] = middle * dx - across * dy, middle * dy + across * dx
    # The bright side is on the right, the direction of rising offsets.
    row[5] = 0.0 if same else (1.0 if offset_j > offset_i else -1.0)
    return True


@njit(cache=True, error_model='numpy')
def _offset(line: Floats, dx: float, dy: float, along: float) -> float:
    """Return a line's offset along the normal (-dy, dx) at a position along the direction (dx, dy) [px]."""
    s0, s1 = dx * line[0, 0] + dy * line[0, 1], dx * line[1, 0] + dy * line[1, 1]
    t0, t1 = dx * line[0, 1] - dy * line[0, 0], dx * line[1, 1] - dy * line[1, 0]
    return t0 + (t1 - t0) * (along - s0) / (s1 - s0)
