"""Where a lamp's light falls on the pixels of a window, exact to a small part of a pixel.

Each pixel's ray is followed to the plane of the lamp's face at the pixel's own time. There the distance to the
edge is known exactly; the gradient of the map from pixels to the plane turns it into pixels, in two Newton steps.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scene_simulator.ceiling.lamp import CeilingLamp, ShapeKind
from scene_simulator.ceiling.lens import Blooming, edge_light, glow_light

_DISC, _LED_GRID = int(ShapeKind.DISC), int(ShapeKind.LED_GRID)
_DEEP, _FAR = -16.0, 40.0  # distances from an edge, inside and outside, that need not be exact [px]


@njit(cache=True)
def edge_distance(s: float, t: float, kind: int, sizes: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return the distance of a point (s, t) of a face [m] from the edge of its shape.

    Returns:
        signed distance, outside positive [m], and its gradient along s and t, a unit vector.
    """
    if kind == _DISC:
        return _circle(s, t, sizes[0])
    if kind == _LED_GRID:
        last = sizes[2] - 1.0
        return _circle(_from_led(s, sizes[1], last, last), _from_led(t, sizes[1], last, last), sizes[0])
    return _box(s, t, sizes[0], sizes[1])


@njit(cache=True)
def half_edge_distance(
    s: float, t: float, kind: int, sizes: tuple[float, float, float], side: float
) -> tuple[float, float, float]:
    """Return as ``edge_distance`` for one half of a shape, the line between the halves included.

    The side is 1 for the half with negative s, -1 for the other.
    """
    s *= side
    if kind == _DISC:
        distance, along_s, along_t = _half_circle(s, t, sizes[0])
    elif kind == _LED_GRID:
        last = sizes[2] - 1.0
        column = _from_led(s, sizes[1], last, math.floor(0.5 * last))
        distance, along_s, along_t = _circle(column, _from_led(t, sizes[1], last, last), sizes[0])
    else:
        distance, along_s, along_t = _box(s + 0.5 * sizes[0], t, 0.5 * sizes[0], sizes[1])
    return distance, side * along_s, along_t


@njit(cache=True)
def _from_led(place: float, pitch: float, last: float, last_included: float) -> float:
    """Return a place along an axis relative to the nearest of the LEDs 0 to ``last_included`` of 0 to ``last`` [m]."""
    index = min(max(round(place / pitch + 0.5 * last), 0.0), last_included)
    return place - pitch * (index - 0.5 * last)


@njit(cache=True)
def _circle(s: float, t: float, radius: float) -> tuple[float, float, float]:
    middle = math.hypot(s, t)
    if middle < 1e-12:
        return -radius, 1.0, 0.0
    return middle - radius, s / middle, t / middle


@njit(cache=True)
def _half_circle(s: float, t: float, radius: float) -> tuple[float, float, float]:
    """As ``_circle`` for the half with negative s."""
    rim = _circle(s, t, radius)
    if s <= 0.0:
        return rim if rim[0] > s else (s, 1.0, 0.0)
    beyond = abs(t) - radius
    if beyond <= 0.0:
        return s, 1.0, 0.0
    distance = math.hypot(s, beyond)
    return distance, s / distance, math.copysign(beyond, t) / distance


@njit(cache=True)
def _box(s: float, t: float, half_width: float, half_length: float) -> tuple[float, float, float]:
    outside_s, outside_t = abs(s) - half_width, abs(t) - half_length
    if outside_s > 0.0 and outside_t > 0.0:
        distance = math.hypot(outside_s, outside_t)
        return distance, math.copysign(outside_s, s) / distance, math.copysign(outside_t, t) / distance
    if outside_s > outside_t:
        return outside_s, math.copysign(1.0, s), 0.0
    return outside_t, 0.0, math.copysign(1.0, t)


def face_homographies(
    xyz: tuple[float, float, float],
    rotation: NDArray[np.float64],
    positions: NDArray[np.float64],
    rotations: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the maps from rays to the plane of a face.

    Args:
        xyz: origin of the face in the map frame [m].
        rotation: shape (3, 3), ``R_map_face``.
        positions: shape (n, 3), optical centres in the map frame [m].
        rotations: shape (n, 3, 3), ``R_map_camera``.

    Returns:
        array, shape (n, 3, 3): times a ray (x, y, 1) it gives (w s, w t, w) with s and t on the face [m] and
        w > 0 where the ray runs towards the plane.
    """
    first, second, normal = rotation.T
    offsets = positions - np.array(xyz)
    depths = -offsets @ normal
    rows = [depths[:, None] * axis + (offsets @ axis)[:, None] * normal for axis in (first, second)]
    from_map = np.stack([*rows, np.broadcast_to(normal, offsets.shape)], axis=1)
    return np.asarray(np.where(depths < 0.0, -1.0, 1.0)[:, None, None] * (from_map @ rotations))


def lamp_profiles(
    lamp: CeilingLamp, blooming: Blooming, rays: NDArray[np.float64], homographies: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Return how much of the light of each part of a lamp falls on each pixel of a window.

    Where both parts are equally bright, their sum is eq. (4) for the whole lamp. It is divided among them in proportion
    to eq. (4) for the outline of each part alone, with the glow of the whole lamp: so blooming and glow carry light of
    one part over the other.

    Args:
        lamp: the lamp.
        blooming: the glow.
        rays: shape (rows + 2, columns + 2, 2), rays of the pixels and of a border of one pixel, z = 1.
        homographies: shape (rows, 3, 3), from ``face_homographies``, at one instant for each row.

    Returns:
        array, shape (parts, rows, columns), 0 to 1.
    """
    shape = (lamp.waveform.parts, rays.shape[0] - 2, rays.shape[1] - 2)
    profiles = np.empty(shape, dtype=np.float32)
    _fill(profiles, rays, homographies, int(lamp.shape.kind), lamp.shape.sizes, blooming.parameters)
    return profiles


@njit(cache=True)
def _fill(
    profiles: NDArray[np.float32],
    rays: NDArray[np.float64],
    homographies: NDArray[np.float64],
    kind: int,
    sizes: tuple[float, float, float],
    bloom: tuple[float, float, float, float],
) -> None:
    parts, rows, columns = profiles.shape
    for row in range(rows):
        h = homographies[row]
        for column in range(columns):
            distance = _pixels_from_edge(rays, row, column, h, kind, sizes, 0.0)
            glow = glow_light(distance, bloom)
            light = glow + (1.0 - glow) * edge_light(distance, bloom)
            if parts == 1:
                profiles[0, row, column] = light
                continue
            first = edge_light(_pixels_from_edge(rays, row, column, h, kind, sizes, 1.0), bloom)
            second = edge_light(_pixels_from_edge(rays, row, column, h, kind, sizes, -1.0), bloom)
            fraction = (glow + (1.0 - glow) * first) / (2.0 * glow + (1.0 - glow) * (first + second))
            profiles[0, row, column] = light * fraction
            profiles[1, row, column] = light * (1.0 - fraction)


@njit(cache=True)
def _pixels_from_edge(
    rays: NDArray[np.float64],
    row: int,
    column: int,
    h: NDArray[np.float64],
    kind: int,
    sizes: tuple[float, float, float],
    side: float,
) -> float:
    """Return the signed distance of a pixel of a window from the edge of a shape, outside positive [px].

    The side is 1 or -1 for one half of it, see ``half_edge_distance``, and 0 for the whole; h is the homography.
    """
    v, u, pixels = row + 1.0, column + 1.0, 0.0
    # The first step leads about to the edge; perspective and distortion leave something to the second.
    for _ in range(2):
        i = min(max(round(v), 1), rays.shape[0] - 2)
        j = min(max(round(u), 1), rays.shape[1] - 2)
        x_u = 0.5 * (rays[i, j + 1, 0] - rays[i, j - 1, 0])
        y_u = 0.5 * (rays[i, j + 1, 1] - rays[i, j - 1, 1])
        x_v = 0.5 * (rays[i + 1, j, 0] - rays[i - 1, j, 0])
        y_v = 0.5 * (rays[i + 1, j, 1] - rays[i - 1, j, 1])
        x = rays[i, j, 0] + (u - j) * x_u + (v - i) * x_v
        y = rays[i, j, 1] + (u - j) * y_u + (v - i) * y_v
        w = h[2, 0] * x + h[2, 1] * y + h[2, 2]
        if w <= 1e-9:
            return math.inf
        s = (h[0, 0] * x + h[0, 1] * y + h[0, 2]) / w
        t = (h[1, 0] * x + h[1, 1] * y + h[1, 2]) / w
        if side == 0.0:
            distance, along_s, along_t = edge_distance(s, t, kind, sizes)
        else:
            distance, along_s, along_t = half_edge_distance(s, t, kind, sizes, side)
        along_x = (along_s * (h[0, 0] - s * h[2, 0]) + along_t * (h[1, 0] - t * h[2, 0])) / w
        along_y = (along_s * (h[0, 1] - s * h[2, 1]) + along_t * (h[1, 1] - t * h[2, 1])) / w
        along_u, along_v = along_x * x_u + along_y * y_u, along_x * x_v + along_y * y_v
        steepness = math.hypot(along_u, along_v)
        pixels += distance / steepness
        if not _DEEP < pixels < _FAR:
            return pixels
        u -= distance * along_u / steepness**2
        v -= distance * along_v / steepness**2
    return pixels
