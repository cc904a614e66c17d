"""Arcs and geometry of an ellipse, and its least squares fit (Fitzgibbon et al. 1999; Halíř and Flusser 1998)."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.arrays import Floats, Ints

# A larger turning angle is a corner [rad]; a polyline edge this many times longer than the next one is straight.
_TURNING_ANGLE_MAX = 1.2
_LENGTH_RATIO_MAX = 5.0
# A shorter or straighter arc does not constrain its ellipse [px, rad].
_LENGTH_MIN = 8.0
_TURN_MIN = 0.4


@njit(cache=True, error_model='numpy')
def find_arcs(
    points: Floats, vertex_indices: NDArray[np.int32], vertex_starts: NDArray[np.int32]
) -> tuple[Ints, Floats]:
    """Return the arcs by falling product of turn and length.

    Args:
        points: points of all segments, shape (n, 2) [px].
        vertex_indices: indices of the polyline vertices in ``points``.
        vertex_starts: start of each segment in ``vertex_indices``, shape (m + 1,).

    Returns:
        first and last point of each arc, shape (k, 2); total turn, positive to the right [rad], and
        length [px] of each arc, shape (k, 2).
    """
    spans, shapes = np.empty((len(vertex_indices) + 1, 2), np.int64), np.empty((len(vertex_indices) + 1, 2))
    count = 0
    for s in range(len(vertex_starts) - 1):
        first, end = vertex_starts[s], vertex_starts[s + 1]
        begin, total_turn = first, 0.0
        for b in range(first + 1, end):
            turn = _smooth_turning_angle(points, vertex_indices, b) if b < end - 1 else 0.0
            if turn * total_turn > 0.0 or (total_turn == 0.0 and turn != 0.0 and begin == b - 1):
                total_turn += turn
                continue
            count += _append_arc(
                points, vertex_indices[begin], vertex_indices[b], total_turn, spans[count], shapes[count]
            )
            # An arc may continue in one of the opposite sense: both share the polyline edge between them.
            begin, total_turn = (b - 1, turn) if turn != 0.0 else (b, 0.0)
    order = np.argsort(-np.abs(shapes[:count, 0]) * shapes[:count, 1])
    return spans[order], shapes[order]


@njit(cache=True, error_model='numpy')
def _smooth_turning_angle(points: Floats, vertex_indices: NDArray[np.int32], b: int) -> float:
    """Return the turning angle at a vertex, 0 at a corner or the end of a straight run [rad]."""
    ax, ay = points[vertex_indices[b]] - points[vertex_indices[b - 1]]
    bx, by = points[vertex_indices[b + 1]] - points[vertex_indices[b]]
    before, after = np.sqrt(ax * ax + ay * ay), np.sqrt(bx * bx + by * by)
    turn = np.arctan2(ax * by - ay * bx, ax * bx + ay * by)
    if abs(turn) > _TURNING_ANGLE_MAX or max(before, after) > _LENGTH_RATIO_MAX * min(before, after):
        return 0.0
    return turn


@njit(cache=True, error_model='numpy')
def _append_arc(points: Floats, first: int, last: int, total_turn: float, span: Ints, shape: Floats) -> int:
    length = 0.0
    for i in range(first, last):
        length += np.hypot(points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1])
    if length < _LENGTH_MIN or abs(total_turn) < _TURN_MIN:
        return 0
    span[0], span[1] = first, last
    shape[0], shape[1] = total_turn, length
    return 1


@njit(cache=True, error_model='numpy')
def ellipse_point(parameters: Floats, t: float) -> tuple[float, float, float, float, float]:
    """Return a point of the ellipse, its outward unit normal and the speed |dP/dt|.

    Args:
        parameters: centre x, y, semi-axes a, b [px], tilt [rad], shape (5,).
        t: curve parameter in c + R(tilt) (a cos t, b sin t) [rad].

    Returns:
        x, y [px], normal x, y, speed [px / rad].
    """
    cx, cy, a, b, tilt = parameters
    cos_t, sin_t, cos_r, sin_r = np.cos(t), np.sin(t), np.cos(tilt), np.sin(tilt)
    speed = np.sqrt((a * sin_t) ** 2 + (b * cos_t) ** 2)
    px, py, nx, ny = a * cos_t, b * sin_t, b * cos_t / speed, a * sin_t / speed
    return (
        cx + cos_r * px - sin_r * py,
        cy + sin_r * px + cos_r * py,
        cos_r * nx - sin_r * ny,
        sin_r * nx + cos_r * ny,
        speed,
    )


@njit(cache=True, error_model='numpy')
def normal_jacobian_row(parameters: Floats, t: float, row: Floats) -> None:
    """Write the derivatives of the outline's position along its normal by the parameters, shape (5,)."""
    a, b = parameters[2], parameters[3]
    _, _, nx, ny, speed = ellipse_point(parameters, t)
    cos_t, sin_t = np.cos(t), np.sin(t)
    row[0], row[1] = nx, ny
    row[2] = b * cos_t * cos_t / speed
    row[3] = a * sin_t * sin_t / speed
    row[4] = (a * a - b * b) * sin_t * cos_t / speed


@njit(cache=True, error_model='numpy')
def normal_jacobian(parameters: Floats, count: int) -> Floats:
    """Return the rows of `normal_jacobian_row` at ``count`` evenly spaced curve parameters, shape (count, 5)."""
    rows = np.empty((count, 5))
    for k in range(count):
        normal_jacobian_row(parameters, 2.0 * np.pi * k / count, rows[k])
    return rows


@njit(cache=True, error_model='numpy')
def foot_point(a: float, b: float, u: float, v: float) -> tuple[float, float, float]:
    """Return cosine and sine of the curve parameter of the nearest point of the outline, and the speed |dP/dt| there.

    Args:
        a: semi-axis along u [px].
        b: semi-axis along v [px].
        u: coordinate of a point near the outline, along the first axis of the ellipse [px].
        v: coordinate of the point along the second axis [px].
    """
    cos_t, sin_t = u * b, v * a
    norm = np.sqrt(cos_t * cos_t + sin_t * sin_t)
    cos_t, sin_t = (cos_t / norm, sin_t / norm) if norm > 0.0 else (1.0, 0.0)
    for _ in range(3):
        # Newton's method on (P - Q) . dP/dt = 0; the small rotation avoids trigonometric functions.
        dx, dy = a * cos_t - u, b * sin_t - v
        slope = dy * b * cos_t - dx * a * sin_t
        bend = (a * sin_t) ** 2 + (b * cos_t) ** 2 - dx * a * cos_t - dy * b * sin_t
        if bend > 0.0:
            turn = -slope / bend
            cos_t, sin_t = cos_t - turn * sin_t, sin_t + turn * cos_t
            norm = np.sqrt(1.0 + turn * turn)
            cos_t, sin_t = cos_t / norm, sin_t / norm
    return cos_t, sin_t, np.sqrt((a * sin_t) ** 2 + (b * cos_t) ** 2)


@njit(cache=True, error_model='numpy')
def perimeter(a: float, b: float) -> float:
    """Return the perimeter of an ellipse by Ramanujan's second formula [px]."""
    h = ((a - b) / (a + b)) ** 2
    return np.pi * (a + b) * (1.0 + 3.0 * h / (10.0 + np.sqrt(4.0 - 3.0 * h)))


# Smallest determinant of the scatter matrix of scaled points; below it they are collinear.
_COLLINEAR_TOLERANCE = 1e-9


@njit(cache=True, error_model='numpy')
def fit_ellipse(points: Floats, parameters: Floats) -> bool:
    """Fit an ellipse to points of its outline and write its parameters.

    Args:
        points: five or more points, shape (n, 2) [px].
        parameters: output, centre x, y, semi-axes a >= b [px] and tilt [rad], shape (5,).

    Returns:
        whether the fit succeeded; False for collinear points.
    """
    n = len(points)
    mx, my = np.mean(points[:, 0]), np.mean(points[:, 1])
    scale = np.sqrt(np.mean((points[:, 0] - mx) ** 2 + (points[:, 1] - my) ** 2))
    if n < 5 or scale < 1e-9:
        return False
    sums = _moments(points, mx, my, scale)
    xx, xy, yy = sums[2, 0], sums[1, 1], sums[0, 2]
    determinant = xx * yy - xy * xy
    if determinant < _COLLINEAR_TOLERANCE * n * n:
        return False
    # Linear coefficients (d, e, f) as a function of the quadratic coefficients (a, b, c), column by column.
    to_linear, reduced, quadratic, linear = np.empty((3, 3)), np.empty((3, 3)), np.empty(3), np.zeros(3)
    for c in range(3):
        p, q, r = sums[3 - c, c], sums[2 - c, 1 + c], sums[2 - c, c]
        to_linear[0, c] = (xy * q - yy * p) / determinant
        to_linear[1, c] = (xy * p - xx * q) / determinant
        to_linear[2, c] = -r / n
    for r in range(3):
        factor = (0.5, -1.0, 0.5)[r] / n
        for c in range(3):
            k = 2 - r
            total = sums[4 - k - c, k + c] + sums[3 - k, k] * to_linear[0, c]
            total += sums[2 - k, 1 + k] * to_linear[1, c] + sums[2 - k, k] * to_linear[2, c]
            reduced[r, c] = factor * total
    if not _ellipse_eigenvector(reduced, quadratic):
        return False
    for r in range(3):
        for c in range(3):
            linear[r] += to_linear[r, c] * quadratic[c]
    if not _axes(quadratic, linear, parameters):
        return False
    parameters[0], parameters[1] = parameters[0] * scale + mx, parameters[1] * scale + my
    parameters[2], parameters[3] = parameters[2] * scale, parameters[3] * scale
    return True


@njit(cache=True, error_model='numpy')
def _moments(points: Floats, mx: float, my: float, scale: float) -> Floats:
    """Return the moments, sums of x^i y^j of centred and scaled points, up to the fourth order, shape (5, 5)."""
    sums = np.zeros((5, 5))
    for k in range(len(points)):
        x, y = (points[k, 0] - mx) / scale, (points[k, 1] - my) / scale
        power = 1.0
        for i in range(5):
            product = power
            for j in range(5 - i):
                sums[i, j] += product
                product *= y
            power *= x
    return sums


@njit(cache=True, error_model='numpy')
def _ellipse_eigenvector(m: Floats, vector: Floats) -> bool:
    """Write the eigenvector a, b, c of a 3 x 3 matrix with real eigenvalues for which 4 a c > b²."""
    third = (m[0, 0] + m[1, 1] + m[2, 2]) / 3.0
    a, b, c = m[0, 0] - third, m[1, 1] - third, m[2, 2] - third
    p = -(a * b + a * c + b * c - m[0, 1] * m[1, 0] - m[0, 2] * m[2, 0] - m[1, 2] * m[2, 1]) / 3.0
    if p <= 0.0:
        return False
    q = a * (b * c - m[1, 2] * m[2, 1]) - m[0, 1] * (m[1, 0] * c - m[1, 2] * m[2, 0])
    q += m[0, 2] * (m[1, 0] * m[2, 1] - b * m[2, 0])
    angle = np.arccos(min(max(0.5 * q / p**1.5, -1.0), 1.0)) / 3.0
    for k in range(3):
        value = third + 2.0 * np.sqrt(p) * np.cos(angle - 2.0 * np.pi * k / 3.0)
        if _null_vector(m, value, vector) and 4.0 * vector[0] * vector[2] > vector[1] ** 2:
            return True
    return False


@njit(cache=True, error_model='numpy')
def _null_vector(m: Floats, value: float, vector: Floats) -> bool:
    """Write the unit null vector of m - value I: the longest cross product of two of its rows."""
    longest = 0.0
    for r in range(3):
        s = (r + 1) % 3
        ax, ay, az = m[r, 0] - value * (r == 0), m[r, 1] - value * (r == 1), m[r, 2] - value * (r == 2)
        bx, by, bz = m[s, 0] - value * (s == 0), m[s, 1] - value * (s == 1), m[s, 2] - value * (s == 2)
        x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        length = x * x + y * y + z * z
        if length > longest:
            longest = length
            norm = np.sqrt(length)
            vector[0], vector[1], vector[2] = x / norm, y / norm, z / norm
    return longest > 0.0


@njit(cache=True, error_model='numpy')
def _axes(quadratic: Floats, linear: Floats, parameters: Floats) -> bool:
    """Convert a x² + b xy + c y² + d x + e y + f = 0 to centre, semi-axes and tilt."""
    a, b, c = quadratic
    d, e, f = linear
    determinant = 4.0 * a * c - b * b
    x, y = (b * e - 2.0 * c * d) / determinant, (b * d - 2.0 * a * e) / determinant
    level = -(f + 0.5 * (d * x + e * y))
    half, twist = 0.5 * (a + c), np.hypot(0.5 * (a - c), 0.5 * b)
    if level < 0.0:
        a, b, c, level, half = -a, -b, -c, -level, -half
    if half - twist <= 0.0 or level <= 0.0:
        return False
    # The long axis has the smaller curvature.
    tilt = 0.5 * np.arctan2(-b, c - a)
    parameters[0], parameters[1] = x, y
    parameters[2], parameters[3] = np.sqrt(level / (half - twist)), np.sqrt(level / (half + twist))
    parameters[4] = tilt
    return True
