"""The paper's experiment (3.2.1): a camera that a linear actuator moves 50 times by 12 mm, located at 51 places."""

from __future__ import annotations

import math

import numpy as np
from _floor_photographs import CAMERA, SurveyedFloor, photographer
from numpy.typing import NDArray

from floor_localizer.core.fix import Fix
from shirube_core.geometry import SE2, wrap_angle

PLACES, STEP = 51, 0.012
REPEATABILITY = 0.00002
"""Of the actuator, greatest error of a place along its axis [m]."""

_HEAD = '| | places found | deviation mm: rms / max | heading °: standard deviation / max | error mm: mean / max |'
_PAPER = '| the paper, a real floor | 51 of 51 | 0.33 / 0.64 | 0.09 / 0.38 | – |'


def actuator_poses(start: SE2, rng: np.random.Generator) -> list[SE2]:
    """Return where the actuator takes the camera: ahead along the start's heading."""
    ways = STEP * np.arange(PLACES) + rng.uniform(-REPEATABILITY, REPEATABILITY, PLACES)
    return [start @ SE2(float(way), 0.0, 0.0) for way in ways]


def locate_along(floor: SurveyedFloor, poses: list[SE2], rng: np.random.Generator) -> list[SE2]:
    """Return the poses found without a prior, from a photograph at each place; places without one are left out."""
    camera = photographer()
    found = []
    for pose in poses:
        fix = floor.localizer.locate(camera.photograph(floor.floor, [pose], rng=rng).image, CAMERA)
        found += [fix.T_map_base] if isinstance(fix, Fix) else []
    return found


def deviations(found: list[SE2]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return what the paper measures: distances from even places on the line fitted to all [m], and turns from the
    mean heading [rad].
    """
    places = np.array([(pose.x, pose.y) for pose in found])
    steps = np.arange(len(found)) - 0.5 * (len(found) - 1)
    off = places - places.mean(axis=0)
    direction = np.linalg.svd(off, full_matrices=False)[2][0]
    direction *= np.sign(direction @ (off[-1] - off[0]))
    ideal = STEP * steps[:, None] * direction
    turns = [wrap_angle(pose.yaw - found[0].yaw) for pose in found]
    return np.hypot(*(off - ideal).T), np.array(turns) - np.mean(turns)


def actuator_report(floor: SurveyedFloor, lines: int, seed: int) -> str:
    """Return the paper's figures and ours: over several lines, and with their errors against the truth."""
    rng = np.random.default_rng(seed)
    distances, turns, errors, count = [], [], [], 0
    for start in floor.places(lines):
        # The line begins where it ends on the floor, whatever its heading.
        ahead = SE2(start.x, start.y, math.atan2(4.725 - start.y, 0.9 - start.x))
        poses = actuator_poses(ahead, rng)
        found = locate_along(floor, poses, rng)
        count += len(found)
        if len(found) == PLACES:
            line = deviations(found)
            distances.append(line[0])
            turns.append(line[1])
            errors += [pose.distance_to(truth) for pose, truth in zip(found, poses, strict=True)]
    away, turned = 1e3 * np.concatenate(distances), np.degrees(np.concatenate(turns))
    ours = (
        f'| shirube, {lines} rendered lines | {count} of {lines * PLACES} '
        f'| {math.sqrt(np.mean(away**2)):.3f} / {away.max():.3f} '
        f'| {turned.std():.3f} / {np.abs(turned).max():.3f} '
        f'| {1e3 * np.mean(errors):.3f} / {1e3 * max(errors):.3f} |'
    )
    return f'{_HEAD}\n|---|---|---|---|---|\n{_PAPER}\n{ours}'
