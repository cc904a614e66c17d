"""Simulated drives with one faulty source, and the number of wrong poses of the arbiter."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from _arbiter_bags import PoseSample
from _arbiter_fusion import add_message, in_order_of_arrival, messages_of, new_arbiter

from pose_arbiter.core.kalman_filter import diagonal
from scene_simulator.robot.robot_drive import WheelErrors, simulate_odometry
from shirube_core.geometry import SE2, wrap_angle

FAULTS = ('offset', 'turned', 'frozen', 'late', 'jumping', 'drifting')
"""Offset of 0.3 m, yaw of 10 degrees, constant pose, delay of 0.5 s, random offsets, drift of 2 cm/s."""
WRONG_XY, WRONG_YAW = 0.05, math.radians(3.0)
SECONDS, RATE, SOURCE_RATE, OUTPUT = 20.0, 100, 30, 20_000_000
BEGIN = 1_000_000_000_000
_SHIFT = 0.5  # [s]
_DRIFT = 0.02  # [m/s]
_LATENCY = 60_000_000  # [ns]


class Scenario(NamedTuple):
    """Number of correct sources, which publish from the start, and times of the first pose of the faulty source and of
    its first wrong one [s].
    """

    name: str
    correct_sources: int
    faulty_from: float
    fault_from: float


SCENARIOS = (
    Scenario('two correct, the faulty one from the start', 2, 0.0, 0.0),
    Scenario('two correct, the faulty one was established', 2, 0.0, 8.0),
    Scenario('one established, the faulty one is new', 1, 6.0, 6.0),
    Scenario('one established, the faulty one was established', 1, 0.0, 8.0),
)


def wrong_poses(scenario: Scenario, fault: str, seed: int) -> int:
    """Return the number of wrong poses at 50 Hz since the start of the fault."""
    rng = np.random.default_rng([seed, FAULTS.index(fault), SCENARIOS.index(scenario)])
    truth = _drive(rng)
    odometry = _odometry(truth, rng)
    sources = [_correct_source(truth, rng, k) for k in range(scenario.correct_sources)]
    first = BEGIN + scenario.faulty_from * 1e9
    faulty = [o for o in _correct_source(truth, rng, scenario.correct_sources) if o.stamp >= first]
    begin = BEGIN + round(scenario.fault_from * 1e9)
    position, direction = int(rng.integers(scenario.correct_sources + 1)), rng.uniform(-math.pi, math.pi)
    sources.insert(position, [_inject_fault(o, fault, begin, truth, direction, rng) for o in faulty])
    messages = messages_of(sources, odometry)
    arbiter, due, wrong = new_arbiter(len(sources)), BEGIN, 0
    for now, message in in_order_of_arrival(messages, lambda _: _LATENCY):
        add_message(arbiter, message, now)
        while due <= now:
            estimate = arbiter.estimate_at(due)
            if estimate is not None and due >= begin:
                wrong += _is_wrong(estimate.pose, _at(truth, due))
            due += OUTPUT
    return wrong


def _drive(rng: np.random.Generator) -> list[SE2]:
    """Return poses of a winding drive with halts."""
    pose, poses, speed, turn = SE2(0.0, 0.0, rng.uniform(-3.0, 3.0)), [], 0.0, 0.0
    goal_speed, goal_turn = 0.5, 0.0
    for k in range(round(SECONDS * RATE) + 1):
        if k % (2 * RATE) == 0:
            goal_speed, goal_turn = float(rng.choice([0.0, 0.15, 0.3, 0.5])), rng.uniform(-0.6, 0.6)
        speed += float(np.clip(goal_speed - speed, -0.5 / RATE, 0.5 / RATE))
        turn += float(np.clip(goal_turn - turn, -1.0 / RATE, 1.0 / RATE))
        poses.append(pose)
        pose = pose @ SE2(speed / RATE, 0.0, turn / RATE)
    return poses


def _odometry(truth: list[SE2], rng: np.random.Generator) -> list[tuple[int, SE2]]:
    scale, bend = 1.0 + 0.02 * rng.choice([-1, 1]), 0.0026 * rng.choice([-1, 1])  # 2 % and 1 degree a metre
    errors = WheelErrors(0.3, left_scale=scale - bend, right_scale=scale + bend, slip=0.001, tick=8e-5)
    wheels = simulate_odometry(truth, errors, rng)
    return [(BEGIN + k * (1_000_000_000 // RATE), pose) for k, pose in enumerate(wheels)]


def _correct_source(truth: list[SE2], rng: np.random.Generator, number: int) -> list[PoseSample]:
    """Return poses with noise and bias, together as large as the stated sigma."""
    sigma_xy, sigma_yaw = rng.uniform(0.002, 0.012), rng.uniform(0.002, 0.01)
    bias = rng.normal(size=3) * 0.5
    samples = []
    for k in range(round(SECONDS * SOURCE_RATE)):
        stamp = BEGIN + round((k + 0.2 * number) * 1e9 / SOURCE_RATE)
        pose = _at(truth, stamp)
        x, y, yaw = (bias + 0.85 * rng.normal(size=3)) * (sigma_xy, sigma_xy, sigma_yaw)
        estimated = SE2(pose.x + float(x), pose.y + float(y), wrap_angle(pose.yaw + float(yaw)))
        samples.append(PoseSample(stamp, estimated, diagonal(sigma_xy**2, sigma_yaw**2)))
    return samples


def _inject_fault(
    sample: PoseSample, fault: str, begin: int, truth: list[SE2], direction: float, rng: np.random.Generator
) -> PoseSample:
    if sample.stamp < begin:
        return sample
    pose, size, turn = sample.pose, 0.0, 0.0
    match fault:
        case 'offset':
            size = 0.3
        case 'turned':
            turn = math.radians(10.0)
        case 'frozen':
            pose = _at(truth, begin)
        case 'late':
            pose = _at(truth, max(BEGIN, sample.stamp - round(_SHIFT * 1e9)))
        case 'jumping':
            size, direction, turn = rng.uniform(0.1, 2.0), rng.uniform(-math.pi, math.pi), rng.normal()
        case 'drifting':
            size = _DRIFT * (sample.stamp - begin) * 1e-9
    x, y = pose.x + size * math.cos(direction), pose.y + size * math.sin(direction)
    return replace(sample, pose=SE2(x, y, wrap_angle(pose.yaw + turn)))


def _at(truth: list[SE2], stamp: int) -> SE2:
    position = (stamp - BEGIN) * 1e-9 * RATE
    k = min(max(int(position), 0), len(truth) - 2)
    step, fraction = truth[k].inverse() @ truth[k + 1], position - k
    return truth[k] @ SE2(fraction * step.x, fraction * step.y, fraction * step.yaw)


def _is_wrong(pose: SE2, true: SE2) -> bool:
    return pose.distance_to(true) > WRONG_XY or abs(pose.yaw_to(true)) > WRONG_YAW
