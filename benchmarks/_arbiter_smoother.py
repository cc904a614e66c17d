"""The same drive through gtsam's fixed-lag smoother, of which the newest state counts: a second opinion."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Any

import numpy as np
from _arbiter_bags import Opinion

from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.covariance import as_matrix
from pose_arbiter.core.estimate import Estimate, moved_on, told
from pose_arbiter.core.odometry_trail import OdometryTrail
from shirube_geometry import PlanarPose

try:
    gtsam: Any = import_module('gtsam')
except ImportError:
    gtsam = None

IS_INSTALLED = gtsam is not None
INSTALL = "gtsam is not installed; 'pip install --no-deps gtsam' adds its smoother to the comparison"
_LAG = 2.0  # as history_seconds of the arbiter [s]
_LEAST = 1e-5  # keeps the covariance of a stationary robot invertible [m, rad]


def smoothed(
    sources: Sequence[Sequence[Opinion]], odometry: Sequence[tuple[int, PlanarPose]], wanted: int
) -> list[tuple[int, PlanarPose]]:
    """Return the newest state after each opinion of one of the sources, with the noise of odometry of the arbiter."""
    said = sorted(
        ((o, number) for number, source in enumerate(sources) for o in source), key=lambda s: s[0].stamp
    )
    opinions, settings = [opinion for opinion, _ in said], ArbiterSettings()
    trail = OdometryTrail(settings)
    for stamp, pose in odometry:
        trail.add(stamp, pose)
    smoother = gtsam.BatchFixedLagSmoother(_LAG)
    states: list[tuple[int, PlanarPose]] = []
    for number, opinion in enumerate(opinions):
        graph, guess = gtsam.NonlinearFactorGraph(), gtsam.Values()
        start = _pose2(opinion.pose)
        graph.add(gtsam.PriorFactorPose2(number, start, _in_its_own_frame(opinion)))
        if number:
            before, pose = states[-1]
            mark = trail.mark_at(before)
            # From the origin of the odometry's frame, so that the step and its noise are in the robot's own frame.
            origin = told(mark, 0.0, 0.0, 0.0, (0.0,) * 6, 0)
            step = moved_on(origin, trail.mark_at(opinion.stamp), settings)
            noise = gtsam.noiseModel.Gaussian.Covariance(_turned_back(step) + _LEAST**2 * np.eye(3))
            between = gtsam.Pose2(step.x, step.y, step.yaw)
            graph.add(gtsam.BetweenFactorPose2(number - 1, number, between, noise))
            start = _pose2(pose).compose(between)
        guess.insert(number, start)
        seconds = (opinion.stamp - opinions[0].stamp) * 1e-9
        smoother.update(graph, guess, {number: seconds})
        newest = smoother.calculateEstimatePose2(number)
        states.append((opinion.stamp, PlanarPose(newest.x(), newest.y(), newest.theta())))
    return [state for state, (_, number) in zip(states, said, strict=True) if number == wanted]


def _pose2(pose: PlanarPose) -> Any:
    return gtsam.Pose2(pose.x, pose.y, pose.yaw)


def _in_its_own_frame(opinion: Opinion) -> Any:
    return gtsam.noiseModel.Gaussian.Covariance(_rotated(as_matrix(opinion.noise), -opinion.pose.yaw))


def _turned_back(step: Estimate) -> np.ndarray:
    return _rotated(as_matrix(step.covariance), -step.yaw)


def _rotated(covariance: np.ndarray, angle: float) -> np.ndarray:
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]]
    )
    return turn @ covariance @ turn.T
