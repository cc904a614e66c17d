"""Tolerances between the result of a run and its golden file."""

import math
from typing import Any

import numpy as np

Result = dict[str, Any]
TOLERANCES = {'floor_localizer': (5e-5, 5e-4), 'vlc_beacon': (1e-3, 2e-3), 'stereo_landmark': (1e-3, 1e-3),
              'reward_planner_map': (0.0, 0.0), 'pose_arbiter': (5e-4, 5e-4)}  # fmt: skip
"""How far a pose may be from the golden one [m, rad]."""


def compare_poses(name: str, golden: Result, found: Result) -> list[str]:
    """Return how found poses, levels, commands and grids differ from golden ones; empty if they agree."""
    faults = []
    count, expected = found['pose_count'], golden['pose_count']
    if abs(count - expected) > max(2, 0.02 * expected):
        faults.append(f'{count} poses instead of {expected}')
    # A drive that ends within a second of its first pose may end before the next report.
    if found['levels'] and golden['levels'] and found['levels'] != golden['levels']:
        faults.append(f'diagnostic levels {found["levels"]} instead of {golden["levels"]}')
    by_stamp = {stamp: pose for stamp, *pose in found['poses']}
    pairs = [(pose, by_stamp[stamp]) for stamp, *pose in golden['poses'] if stamp in by_stamp]
    if len(pairs) < 0.9 * len(golden['poses']):
        faults.append(f'only {len(pairs)} of {len(golden["poses"])} sampled poses have the same stamp')
    distance, angle = TOLERANCES[name]
    far = sum(
        math.dist(a[:2], b[:2]) > distance or abs(math.remainder(a[2] - b[2], math.tau)) > angle for a, b in pairs
    )
    if far > 0.02 * len(pairs):
        faults.append(f'{far} of {len(pairs)} poses are more than {distance} m or {angle} rad away')
    if found.get('commands') != golden.get('commands'):
        faults.append(f'commands {found.get("commands")} instead of {golden.get("commands")}')
    return faults + compare_grids(golden.get('grids', {}), found.get('grids', {}))


def compare_grids(golden: Result, found: Result) -> list[str]:
    """Return how grids differ; 1 % of the cells may."""
    faults = [f'grids {sorted(found)} instead of {sorted(golden)}'] if found.keys() != golden.keys() else []
    for name in found.keys() & golden.keys():
        one, other = golden[name], found[name]
        if one['size'] != other['size'] or not np.allclose(one['origin'], other['origin'], atol=1e-6):
            faults.append(f'{name}: {other["size"]} at {other["origin"]}, not {one["size"]} at {one["origin"]}')
            continue
        for kind in ('occupied', 'free'):
            changed = np.abs(np.subtract(one[kind], other[kind])).sum()
            if changed > 0.01 * sum(one[kind]) + 2:
                faults.append(f'{name}: {changed} cells differ in {kind}')
    return faults
