"""Where a lamp's light falls on the pixels of a window, exact to a small part of a pixel.

Each pixel's ray is followed to the plane of the lamp's face at the pixel's own time. There the distance to the
edge is known exactly; the gradient of the map from pixels to the plane turns it into pixels.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scene_simulator.blooming import Blooming, edge_light, glow_light
from scene_simulator.ceiling_lamp import CeilingLamp
from scene_simulator.lamp_edge import edge_distance, half_edge_distance
from shirube_geometry import matrix_from_rpy


def face_homographies(
    xyz: tuple[float, float, float],
    rpy: tuple[float, float, float],
    positions: NDArray[np.float64],
    rotations: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the maps from rays to the plane of a face.

    Args:
        xyz: origin of the face in the map frame [m].
        rpy: orientation of the face in the map frame [rad].
        positions: shape (n, 3), optical centres in the map frame [m].
        rotations: shape (n, 3, 3), ``R_map_camera``.

    Returns:
        array, shape (n, 3, 3): times a ray (x, y, 1) it gives (w s, w t, w) with s and t on the face [m] and
        w > 0 where the ray runs towards the plane.
    """
    first, second, normal = matrix_from_rpy(rpy).T
    offsets = positions - np.array(xyz)
    depths = -offsets @ normal
    rows = [depths[:, None] * axis + (offsets @ axis)[:, None] * normal for axis in (first, second)]
    from_map = np.stack([*rows, np.broadcast_to(normal, offsets.shape)], axis=1)
    return np.asarray(np.where(depths < 0.0, -1.0, 1.0)[:, None, None] * (from_map @ rotations))


def lamp_profiles(
    lamp: CeilingLamp, blooming: Blooming, rays: NDArray[np.float64], homographies: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Return how much of the light of each part of a lamp falls on each pixel of a window.

    Where both parts shine alike, their sum is eq. (4) for the whole lamp. It is shared out among them in proportion
    to eq. (4) for the outline of each part alone, with the glow of the whole lamp: so blooming and glow carry light of
    one part over the other.

    Args:
        lamp: the lamp.
        blooming: the glow.
        rays: shape (rows + 2, columns + 2, 2), rays of the pixels and of a border of one pixel, z = 1.
        homographies: shape (rows, instants, 3, 3), from ``face_homographies``.

    Returns:
        array, shape (instants, parts, rows, columns), 0 to 1.
    """
    rows, instants = homographies.shape[:2]
    profiles = np.zeros((instants, lamp.waveform.parts, rows, rays.shape[1] - 2), dtype=np.float32)
    shape = int(lamp.shape.kind), lamp.shape.sizes
    _fill(profiles, rays, homographies, *shape, blooming.parameters)
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
    instants, parts, rows, columns = profiles.shape
    for row in range(rows):
        for instant in range(instants):
            h = homographies[row, instant]
            for column in range(columns):
                x, y = rays[row + 1, column + 1]
                w = h[2, 0] * x + h[2, 1] * y + h[2, 2]
                if w <= 1e-9:
                    continue
                s = (h[0, 0] * x + h[0, 1] * y + h[0, 2]) / w
                t = (h[1, 0] * x + h[1, 1] * y + h[1, 2]) / w
                du = 0.5 * (rays[row + 1, column + 2] - rays[row + 1, column])
                dv = 0.5 * (rays[row + 2, column + 1] - rays[row, column + 1])
                s_x, s_y = (h[0, 0] - s * h[2, 0]) / w, (h[0, 1] - s * h[2, 1]) / w
                t_x, t_y = (h[1, 0] - t * h[2, 0]) / w, (h[1, 1] - t * h[2, 1]) / w
                s_u, s_v = s_x * du[0] + s_y * du[1], s_x * dv[0] + s_y * dv[1]
                t_u, t_v = t_x * du[0] + t_y * du[1], t_x * dv[0] + t_y * dv[1]
                per_pixel = s_u, s_v, t_u, t_v
                distance = _in_pixels(edge_distance(s, t, kind, sizes), per_pixel)
                glow = glow_light(distance, bloom)
                light = glow + (1.0 - glow) * edge_light(distance, bloom)
                if parts == 1:
                    profiles[instant, 0, row, column] = light
                    continue
                first = _in_pixels(half_edge_distance(s, t, kind, sizes, 1.0), per_pixel)
                second = _in_pixels(half_edge_distance(s, t, kind, sizes, -1.0), per_pixel)
                one = glow + (1.0 - glow) * edge_light(first, bloom)
                other = glow + (1.0 - glow) * edge_light(second, bloom)
                profiles[instant, 0, row, column] = light * one / (one + other)
                profiles[instant, 1, row, column] = light * other / (one + other)


@njit(cache=True)
def _in_pixels(edge: tuple[float, float, float], per_pixel: tuple[float, float, float, float]) -> float:
    """Return a distance [px], to first order, from one on the face and its gradient.

    Args:
        edge: signed distance [m] and its derivatives along s and t.
        per_pixel: derivatives of s along u and v and of t along u and v [m/px].
    """
    distance, along_s, along_t = edge
    s_u, s_v, t_u, t_v = per_pixel
    return distance / math.hypot(along_s * s_u + along_t * t_u, along_s * s_v + along_t * t_v)
