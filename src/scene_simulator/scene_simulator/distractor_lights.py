"""Distractor lights without a code: spots, windows, mains-powered lamps, and reflections of lamps."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from scene_simulator.ceiling_lamp import CeilingLamp
from scene_simulator.errors import SceneError
from scene_simulator.lamp_shape import Disc, Rectangle
from shirube_core.waveform import Waveform, waveform_from_steps

_STEPS = 64
"""Steps in which a period of the mains' flicker is played."""


def mains_flicker(frequency: float = 100.0, depth: float = 0.3) -> Waveform:
    """Return the light of a room lamp on the mains: a raised cosine, brightest in the middle of the period.

    Args:
        frequency: flicker frequency, twice the mains frequency [Hz].
        depth: fraction of the light that is missing at the darkest, 0 to 1.
    """
    middles = (np.arange(_STEPS) + 0.5) / _STEPS
    levels = 1.0 - depth * np.square(np.cos(np.pi * middles))
    return waveform_from_steps(np.full(_STEPS, 1.0 / (_STEPS * frequency)), levels)


def distractors(brightness: float = 2000.0) -> tuple[CeilingLamp, ...]:
    """Return lights without a code in the paper's room: a spot, a flickering tube and panel, a window.

    Args:
        brightness: brightness of the spot, in full wells per second of exposure [1/s]; the others are dimmer.
    """
    mains = mains_flicker()
    window = (math.pi / 2.0, 0.0, 0.0)
    return (
        CeilingLamp((0.9, 2.6, 2.48), Disc(0.04), brightness=brightness),
        CeilingLamp((-0.8, 0.9, 2.45), Rectangle(0.03, 1.2), mains, 0.7 * brightness),
        CeilingLamp((2.9, 0.3, 2.5), Rectangle(0.3, 0.3), mains, 0.4 * brightness, phase=0.003),
        CeilingLamp((0.9, 3.9, 1.9), Rectangle(1.6, 1.0), brightness=0.6 * brightness, rpy=window),
    )


def reflection(
    lamp: CeilingLamp, wall_point: ArrayLike, wall_normal: ArrayLike, reflectance: float = 0.1
) -> CeilingLamp:
    """Return a lamp as a glass wall or a polished one shows it: its own code at a wrong place.

    Args:
        lamp: the lamp.
        wall_point: array-like, shape (3,), a point of the wall in the map frame [m].
        wall_normal: array-like, shape (3,), across the wall, of any length.
        reflectance: fraction of the light that is reflected, 0 to 1.

    Returns:
        the mirrored lamp behind the wall, which is taken to be without end.

    Raises:
        SceneError: a normal without direction.
    """
    normal = np.asarray(wall_normal, dtype=np.float64)
    length = float(np.linalg.norm(normal))
    if not 0.0 < length < math.inf:
        raise SceneError('the normal of a mirror has no direction: give a finite vector that is not zero')
    mirror = np.eye(3) - 2.0 * np.outer(normal, normal) / length**2
    point = np.asarray(wall_point, dtype=np.float64)
    x, y, z = (point + mirror @ (np.array(lamp.xyz) - point)).tolist()
    first, second = (mirror @ lamp.rotation[:, :2]).T
    # A mirrored frame is left-handed; the face shines to both sides, so its normal may be turned about.
    turned = Rotation.from_matrix(np.column_stack([first, second, np.cross(first, second)]))
    roll, pitch, yaw = turned.as_euler('xyz').tolist()
    return replace(lamp, xyz=(x, y, z), rpy=(roll, pitch, yaw), brightness=reflectance * lamp.brightness)
