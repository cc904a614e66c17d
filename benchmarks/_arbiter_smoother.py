"""The same drive through gtsam's fixed-lag smoother, of which the newest state counts: a second opinion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from _arbiter_bags import PoseSample
from scipy.spatial.transform import Rotation

from pose_arbiter.core.kalman_filter import Covariance, as_matrix, initialize, predict
from pose_arbiter.core.settings import ArbiterSettings
from shirube_core.geometry import SE2
from shirube_core.motion import OdometryBuffer

_LAG = 2.0  # as history_seconds of the arbiter [s]
_MIN_SIGMA = 1e-5  # keeps the covariance of a stationary robot invertible [m, rad]


def smooth(
    gtsam: Any, sources: Sequence[Sequence[PoseSample]], odometry: Sequence[tuple[int, SE2]], wanted: int
) -> list[tuple[int, SE2]]:
    """Return the newest state after each opinion of one of the sources, with the noise of odometry of the arbiter."""
    sources_by_sample = sorted(
        ((o, number) for number, source in enumerate(sources) for o in source), key=lambda s: s[0].stamp
    )
    samples, settings = [sample for sample, _ in sources_by_sample], ArbiterSettings()
    buffer = OdometryBuffer(history=2**63)
    for stamp, pose in odometry:
        buffer.add(stamp, pose)
    smoother = gtsam.BatchFixedLagSmoother(_LAG)
    states: list[tuple[int, SE2]] = []
    for number, sample in enumerate(samples):
        graph, guess = gtsam.NonlinearFactorGraph(), gtsam.Values()
        start = _pose2(gtsam, sample.pose)
        graph.add(gtsam.PriorFactorPose2(number, start, _noise(gtsam, sample.noise, sample.pose.yaw)))
        if number:
            before, pose = states[-1]
            odometry_before = buffer.lookup(before)
            # From the origin of the odometry's frame, so that the step and its noise are in the robot's own frame.
            origin = initialize(odometry_before, SE2(0.0, 0.0, 0.0), (0.0,) * 6, 0)
            step = predict(origin, buffer.lookup(sample.stamp), settings)
            noise = _noise(gtsam, step.covariance, step.yaw, _MIN_SIGMA)
            relative_pose = gtsam.Pose2(step.x, step.y, step.yaw)
            graph.add(gtsam.BetweenFactorPose2(number - 1, number, relative_pose, noise))
            start = _pose2(gtsam, pose).compose(relative_pose)
        guess.insert(number, start)
        seconds = (sample.stamp - samples[0].stamp) * 1e-9
        smoother.update(graph, guess, {number: seconds})
        newest = smoother.calculateEstimatePose2(number)
        states.append((sample.stamp, SE2(newest.x(), newest.y(), newest.theta())))
    return [state for state, (_, number) in zip(states, sources_by_sample, strict=True) if number == wanted]


def _pose2(gtsam: Any, pose: SE2) -> Any:
    return gtsam.Pose2(pose.x, pose.y, pose.yaw)


def _noise(gtsam: Any, covariance: Covariance, yaw: float, sigma_min: float = 0.0) -> Any:
    """Return a covariance in the frame of the robot at a yaw [rad]."""
    R = Rotation.from_euler('z', -yaw).as_matrix()
    return gtsam.noiseModel.Gaussian.Covariance(R @ as_matrix(covariance) @ R.T + sigma_min**2 * np.eye(3))
