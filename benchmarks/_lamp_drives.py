"""Drives of half a minute under the lamps, with odometry that is off."""

import math
from collections.abc import Iterator

import numpy as np
from _lamp_room import BEACONS, CAMERA, IDS, MOUNT, view_from
from numpy.typing import NDArray

from scene_simulator.robot.robot_drive import WheelErrors, simulate_odometry
from shirube_core.geometry import SE2, wrap_angle
from vlc_beacon.core.pose.beacon_tracker import BeaconTracker
from vlc_beacon.core.pose.pose_fix import BeaconFix

RATE = 60.0  # images a second
SECONDS = 30.0
SPEED = 0.4  # [m/s]
GAP = 3.0  # [s]
SEPARATION = 0.3
SCALE_ERROR, TURN_ERROR = 0.02, math.radians(0.2)  # 2 % of the way and 0.2 degrees a metre
CENTRE = 0.9


def drive(rng: np.random.Generator) -> tuple[list[SE2], list[SE2]]:
    """Return true poses and the odometry of a winding way about the middle of the room."""
    pose, turn, phase = SE2(CENTRE, CENTRE, rng.uniform(-math.pi, math.pi)), 0.0, rng.uniform(0.0, 6.0)
    poses = [pose]
    for k in range(round(SECONDS * RATE)):
        far = math.hypot(CENTRE - pose.x, CENTRE - pose.y)
        home = wrap_angle(math.atan2(CENTRE - pose.y, CENTRE - pose.x) - pose.yaw)
        wanted = 1.5 * home if far > 1.5 else 0.8 * math.sin(0.01 * k + phase)
        turn += 0.05 * (min(max(wanted, -0.8), 0.8) - turn)
        pose = pose @ SE2(SPEED / RATE, 0.0, turn / RATE)
        poses.append(pose)
    sign = rng.choice([-1.0, 1.0], 2)
    scale, bend = 1.0 + sign[0] * SCALE_ERROR, sign[1] * TURN_ERROR * 0.5 * SEPARATION
    errors = WheelErrors(SEPARATION, left_scale=scale - bend, right_scale=scale + bend)
    return poses, simulate_odometry(poses, errors, rng)


def lamps_shown(rule: str, k: int, visible: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which lamps a rule lets through in image k: all for a second, then one or none."""
    if rule == 'all' or k < RATE:
        return visible
    shown = np.zeros_like(visible)
    is_gap = int(k / (GAP * RATE)) % 2 == 0
    if not (rule == 'gaps' and is_gap):
        shown[np.flatnonzero(visible)[:1]] = True
    return shown


def errors_of_drive(rule: str, noise: float, seed: int) -> Iterator[tuple[float, float]]:
    """Yield error [m] and standard deviations of each image with a pose, NaN where there is none."""
    rng = np.random.default_rng(seed)
    tracker = BeaconTracker(BEACONS, MOUNT)
    for k, (pose, odometry) in enumerate(zip(*drive(rng), strict=True)):
        view = view_from(pose)
        shown = lamps_shown(rule, k, view.visible)
        pixels = view.pixels[shown] + noise * rng.normal(size=(int(shown.sum()), 2))
        tracker.add_odometry(odometry)
        rays = tracker.locator.rays(CAMERA, IDS[shown], pixels, np.full(len(pixels), noise))
        fix = tracker.track(rays)
        if not isinstance(fix, BeaconFix):
            yield math.nan, math.nan
            continue
        error = np.array([fix.T_map_base.x - pose.x, fix.T_map_base.y - pose.y])
        spread = error @ np.linalg.solve(fix.covariance[:2, :2], error)
        yield math.hypot(*error), math.sqrt(0.5 * float(spread))
