"""Simulated drives with one faulty source, and the number of wrong poses of the arbiter."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from _arbiter_bags import Opinion
from _arbiter_fusion import messages_of, new_arbiter, pose_of, tell

from pose_arbiter.core.covariance import diagonal
from scene_simulator.wheel_odometry import WheelErrors, measure_odometry
from shirube_geometry import PlanarPose, wrap_angle

LIES = ('offset', 'turned', 'frozen', 'late', 'jumping', 'drifting')
"""Offset of 0.3 m, yaw of 10 degrees, constant pose, delay of 0.5 s, random offsets, drift of 2 cm/s."""
WRONG_XY, WRONG_YAW = 0.05, math.radians(3.0)
SECONDS, RATE, SOURCE_RATE, OUTPUT = 20.0, 100, 30, 20_000_000
BEGIN = 1_000_000_000_000
_SHIFT = 0.5  # [s]
_CREEP = 0.02  # [m/s]
_LATENCY = 60_000_000  # [ns]


@dataclass(frozen=True)
class Crew:
    """The sources of a drive.

    Attributes:
        name: row label in the table.
        correct_sources: number of correct sources, which publish from the start.
        faulty_from: time of the first pose of the faulty source [s].
        fault_from: time of the first wrong pose of the faulty source [s].
    """

    name: str
    honest: int
    liar_from: float
    lie_from: float


CREWS = (
    Crew('two correct, the faulty one from the start', 2, 0.0, 0.0),
    Crew('two correct, the faulty one was established', 2, 0.0, 8.0),
    Crew('one established, the faulty one is new', 1, 6.0, 6.0),
    Crew('one established, the faulty one was established', 1, 0.0, 8.0),
)


def wrong_poses(crew: Crew, lie: str, seed: int) -> tuple[int, int]:
    """Return the number of wrong poses at 50 Hz since the start of the fault, and the number of all of them."""
    rng = np.random.default_rng([seed, LIES.index(lie), CREWS.index(crew)])
    truth = _drive(rng)
    odometry = _odometry(truth, rng)
    sources = [_honest(truth, rng, k) for k in range(crew.honest)]
    liar = [o for o in _honest(truth, rng, crew.honest) if o.stamp >= BEGIN + crew.liar_from * 1e9]
    begin = BEGIN + round(crew.lie_from * 1e9)
    place, way = int(rng.integers(crew.honest + 1)), rng.uniform(-math.pi, math.pi)
    sources.insert(place, [_lie(o, lie, begin, truth, way, rng) for o in liar])
    messages = messages_of(sources, odometry)
    delays = [0 if m[1] >= len(sources) else _LATENCY for m in messages]
    arrivals = sorted(zip(messages, delays, strict=True), key=lambda pair: pair[0][0] + pair[1])
    arbiter, due, wrong, told = new_arbiter(len(sources)), BEGIN, 0, 0
    for message, delay in arrivals:
        now = message[0] + delay
        tell(arbiter, message, now)
        while due <= now:
            estimate = arbiter.estimate_at(due)
            if estimate is not None and due >= begin:
                told += 1
                wrong += _is_wrong(pose_of(estimate), _at(truth, due))
            due += OUTPUT
    return wrong, told


def _drive(rng: np.random.Generator) -> list[PlanarPose]:
    """Return poses of a winding drive with halts."""
    pose, poses, speed, turn = PlanarPose(0.0, 0.0, rng.uniform(-3.0, 3.0)), [], 0.0, 0.0
    goal_speed, goal_turn = 0.5, 0.0
    for k in range(round(SECONDS * RATE) + 1):
        if k % (2 * RATE) == 0:
            goal_speed, goal_turn = float(rng.choice([0.0, 0.15, 0.3, 0.5])), rng.uniform(-0.6, 0.6)
        speed += float(np.clip(goal_speed - speed, -0.5 / RATE, 0.5 / RATE))
        turn += float(np.clip(goal_turn - turn, -1.0 / RATE, 1.0 / RATE))
        poses.append(pose)
        pose = pose @ PlanarPose(speed / RATE, 0.0, turn / RATE)
    return poses


def _odometry(truth: list[PlanarPose], rng: np.random.Generator) -> list[tuple[int, PlanarPose]]:
    scale, bend = 1.0 + 0.02 * rng.choice([-1, 1]), 0.0026 * rng.choice([-1, 1])  # 2 % and 1 degree a metre
    errors = WheelErrors(0.3, left_scale=scale - bend, right_scale=scale + bend, slip=0.001, tick=8e-5)
    wheels = measure_odometry(truth, errors, rng)
    return [(BEGIN + k * (1_000_000_000 // RATE), pose) for k, pose in enumerate(wheels)]


def _honest(truth: list[PlanarPose], rng: np.random.Generator, number: int) -> list[Opinion]:
    """Return poses with noise and bias, together as large as the stated sigma."""
    sigma_xy, sigma_yaw = rng.uniform(0.002, 0.012), rng.uniform(0.002, 0.01)
    bias = rng.normal(size=3) * 0.5
    opinions = []
    for k in range(round(SECONDS * SOURCE_RATE)):
        stamp = BEGIN + round((k + 0.2 * number) * 1e9 / SOURCE_RATE)
        pose = _at(truth, stamp)
        x, y, yaw = (bias + 0.85 * rng.normal(size=3)) * (sigma_xy, sigma_xy, sigma_yaw)
        said = PlanarPose(pose.x + float(x), pose.y + float(y), wrap_angle(pose.yaw + float(yaw)))
        opinions.append(Opinion(stamp, said, diagonal(sigma_xy**2, sigma_yaw**2)))
    return opinions


def _lie(
    opinion: Opinion, lie: str, begin: int, truth: list[PlanarPose], way: float, rng: np.random.Generator
) -> Opinion:
    if opinion.stamp < begin:
        return opinion
    pose, size, turn = opinion.pose, 0.0, 0.0
    match lie:
        case 'offset':
            size = 0.3
        case 'turned':
            turn = math.radians(10.0)
        case 'frozen':
            pose = _at(truth, begin)
        case 'late':
            pose = _at(truth, max(BEGIN, opinion.stamp - round(_SHIFT * 1e9)))
        case 'jumping':
            size, way, turn = rng.uniform(0.1, 2.0), rng.uniform(-math.pi, math.pi), rng.normal()
        case 'drifting':
            size = _CREEP * (opinion.stamp - begin) * 1e-9
    moved = PlanarPose(
        pose.x + size * math.cos(way), pose.y + size * math.sin(way), wrap_angle(pose.yaw + turn)
    )
    return replace(opinion, pose=moved)


def _at(truth: list[PlanarPose], stamp: int) -> PlanarPose:
    place = (stamp - BEGIN) * 1e-9 * RATE
    k = min(max(int(place), 0), len(truth) - 2)
    step = truth[k].inverse() @ truth[k + 1]
    share = place - k
    return truth[k] @ PlanarPose(share * step.x, share * step.y, share * step.yaw)


def _is_wrong(pose: PlanarPose, true: PlanarPose) -> bool:
    return pose.distance_to(true) > WRONG_XY or abs(pose.turn_to(true)) > WRONG_YAW
