"""Odometry of a folder of images: CSV with image names, or a TUM file with one pose per image in their order."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from shirube_bags.trajectory_files import load_tum
from shirube_core.geometry import SE2, yaw_from_quaternion

COLUMNS = ('image', 'x', 'y', 'yaw')


def load_odometry(path: Path, images: Sequence[Path]) -> list[SE2]:
    """Return ``T_odom_base`` of each image.

    Args:
        path: CSV with the header ``image,x,y,yaw`` (metres, radians), or a TUM file, which has no header and is
            named ``*.tum`` or ``*.txt``.
        images: paths of the images, in order.

    Raises:
        FloorLocalizerError: the file is malformed or images are missing in it.
        TumFileError: the TUM file is malformed.
    """
    if path.suffix.lower() != '.csv':
        return _from_tum(path, len(images))
    known = _from_csv(path)
    for image in images:
        if image.name not in known:
            raise FloorLocalizerError(
                f'{path}: odometry is missing for {image.name}; give one line per image'
            )
    return [known[image.name] for image in images]


def _from_tum(path: Path, count: int) -> list[SE2]:
    trajectory = load_tum(path)
    lines = [
        line for line in path.read_text().splitlines() if line.strip() and not line.lstrip().startswith('#')
    ]
    stamps = [float(line.split()[0]) for line in lines]
    back = np.flatnonzero(np.diff(stamps) <= 0.0)
    if len(back):
        raise FloorLocalizerError(
            f'{path}: its stamps run backwards after {stamps[back[0]]:.3f} s; give the poses in the order of the images'
        )
    if len(trajectory) != count:
        raise FloorLocalizerError(
            f'{path}: has {len(trajectory)} poses for {count} images; give one line per image'
        )
    return [
        SE2(float(xyz[0]), float(xyz[1]), yaw_from_quaternion(*(float(batch) for batch in q)))
        for xyz, q in zip(trajectory.positions, trajectory.quaternions, strict=True)
    ]


def _from_csv(path: Path) -> dict[str, SE2]:
    try:
        rows = list(csv.reader(path.read_text(encoding='utf-8-sig').splitlines()))
    except (OSError, UnicodeDecodeError) as fault:
        raise FloorLocalizerError(
            f'{path}: cannot be read; give a CSV with the header "{",".join(COLUMNS)}"'
        ) from fault
    if not rows or tuple(field.strip().lower() for field in rows[0]) != COLUMNS:
        raise FloorLocalizerError(
            f'{path}, line 1: the header must be "{",".join(COLUMNS)}" (metres and radians)'
        )
    known: dict[str, SE2] = {}
    for number, row in enumerate(rows[1:], start=2):
        if not row:
            continue
        try:
            name, *numbers = row
            x, y, yaw = (float(field) for field in numbers)
        except ValueError as fault:
            raise FloorLocalizerError(
                f'{path}, line {number}: is not a name and three numbers; write "{",".join(COLUMNS)}"'
            ) from fault
        if not all(math.isfinite(value) for value in (x, y, yaw)):
            raise FloorLocalizerError(f'{path}, line {number}: is not finite; give metres and radians')
        if name.strip() in known:
            raise FloorLocalizerError(f'{path}, line {number}: {name} is a duplicate; keep one')
        known[name.strip()] = SE2(x, y, yaw)
    return known
