"""Distances from points of a lamp's face to the edge of its shape, for compiled loops."""

from __future__ import annotations

import math

from numba import njit

from scene_simulator.lamp_shape import ShapeKind

_DISC, _LED_GRID = int(ShapeKind.DISC), int(ShapeKind.LED_GRID)


@njit(cache=True)
def edge_distance(
    s: float, t: float, kind: int, sizes: tuple[float, float, float]
) -> tuple[float, float, float]:
    """Return the distance of a point from a shape's edge.

    Args:
        s: place along the face's x [m].
        t: place along the face's y [m].
        kind: a ``ShapeKind``.
        sizes: dimensions of the shape, see ``LampShape.sizes``.

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
    """Return the distance of a point from the edge of one half of a shape, the line between the halves included.

    Args:
        s: see ``edge_distance``.
        t: see ``edge_distance``.
        kind: see ``edge_distance``.
        sizes: see ``edge_distance``.
        side: 1 for the half with negative s, -1 for the other.

    Returns:
        as ``edge_distance``.
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
    """Return a place along an axis relative to the nearest of the LEDs 0 to ``highest`` of 0 to ``last`` [m]."""
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
