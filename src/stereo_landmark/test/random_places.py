"""Random taught places, and an exact comparison of two values."""

import dataclasses
import math

import numpy as np

from shirube_core.geometry import SE2, CameraMount, PinholeCamera
from shirube_core.settings import describe_settings, settings_from_values
from stereo_landmark.core.primitives.corner import Corner
from stereo_landmark.core.primitives.ellipse import Ellipse
from stereo_landmark.core.primitives.parallel_lines import ParallelLines
from stereo_landmark.core.primitives.primitive import ImageProcessing, point_names
from stereo_landmark.core.primitives.quadrilateral import Quadrilateral
from stereo_landmark.core.procedure.taught_place import TaughtPlace, TaughtPrimitive, TaughtTarget
from stereo_landmark.core.stereo import SpatialPoints, StereoImages, StereoRig

NAMES = ('meter 1', 'yes', '0x1f', 'door: left', "it's", 'Zähler № 3', '- a')
"""Strings that need quoting in YAML."""


def awkward(rng, *shape):
    """Return numbers of all magnitudes."""
    return rng.normal(size=shape) * 10.0 ** rng.uniform(-18.0, 12.0, shape)


def primitive(rng, name):
    """Return a primitive of any kind."""
    tilt, polarity, seen = rng.uniform(-1.5, 1.5), int(rng.integers(-1, 2)), rng.uniform(0.0, 1.0)
    positive = np.abs(awkward(rng, 3)) + 1e-300
    shapes = (
        Ellipse(awkward(rng, 2), positive[:2], tilt, polarity, seen, np.zeros((5, 5))),
        Quadrilateral(awkward(rng, 4, 2), polarity, seen, np.zeros((8, 8))),
        ParallelLines(*positive[:2], tilt, awkward(rng, 2), polarity, np.zeros((3, 3)), positive[2]),
        Corner(awkward(rng, 2), tilt, 2.0 * tilt, positive[:2], polarity, np.zeros((2, 2))),
    )
    normal = awkward(rng, 3) if rng.integers(2) else None
    return TaughtPrimitive(name, shapes[rng.integers(4)], awkward(rng, 3), normal)


def processing(rng):
    """Return settings anywhere within their limits."""
    settings = describe_settings(ImageProcessing)
    values = {each.name: rng.uniform(each.minimum, each.maximum) for each in settings}
    return settings_from_values(ImageProcessing, values)


def random_place(seed, name='hall'):
    """Return a place with every kind of primitive somewhere in it."""
    rng = np.random.default_rng(seed)
    fy, cy = rng.uniform(100.0, 1000.0), rng.uniform(0.0, 300.0)
    fx, left, right = rng.uniform(100.0, 1000.0), rng.uniform(0.0, 400.0), rng.uniform(0.0, 400.0)
    rig = StereoRig(
        PinholeCamera(64, 48, fx, fy, left, cy),
        PinholeCamera(64, 48, fx, fy, right, cy),
        rng.uniform(0.01, 1.0),
        CameraMount(tuple(rng.normal(size=3)), (-math.pi / 2.0, rng.normal() * 1e-9, 0.1)),
    )
    parts = [tuple(primitive(rng, name) for name in rng.permutation(NAMES)[:3].tolist()) for _ in range(2)]
    points_of = [point_names((part.name, part.shape) for part in those) for those in parts]
    names = tuple(f'{target}/{name}' for target, those in zip(NAMES, points_of) for name in those)
    roots = awkward(rng, len(names), 3, 3)
    points = SpatialPoints(names, awkward(rng, len(names), 3), np.array([root.T @ root for root in roots]))
    own = [processing(rng) if seed % 3 == 0 else None for _ in NAMES]
    used = (those[:2] for those in points_of)
    targets = tuple(TaughtTarget(*each) for each in zip(NAMES, parts, used, own))
    around = tuple(primitive(rng, f'corner {i}') for i in range(int(rng.integers(0, 4))))
    pose = SE2(*awkward(rng, 3).tolist()) if seed % 2 else None
    return TaughtPlace(name, rig, targets, points, around, processing(rng), pose)


def random_images(seed):
    """Return a pair of noise."""
    left, right = np.random.default_rng(seed).integers(0, 256, (2, 48, 64), dtype=np.uint8)
    return StereoImages(left, right, (0.01 / 3.0, -0.02))


def is_same(one, other):
    """Return whether two values have the same type and are exactly equal."""
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()
    if dataclasses.is_dataclass(one):
        fields = [field.name for field in dataclasses.fields(one)]
        return type(one) is type(other) and all(is_same(getattr(one, f), getattr(other, f)) for f in fields)
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(is_same, one, other))
    return one == other
