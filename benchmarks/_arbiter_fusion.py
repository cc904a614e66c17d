"""A recorded drive through the arbiter, as its node would see it, and through gtsam's smoother, a second opinion."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from _arbiter_bags import PoseSample
from scipy.spatial.transform import Rotation

from pose_arbiter.core.arbiter import Arbiter
from pose_arbiter.core.kalman_filter import Covariance, initialize, predict
from pose_arbiter.core.settings import ArbiterSettings, SourceSettings
from shirube_core.geometry import SE2
from shirube_core.motion import OdometryBuffer

Message = tuple[int, int, PoseSample | SE2]  # stamp [ns], source index or `ODOMETRY`, and the measurement
ODOMETRY = 1000
_LAG = 2.0  # as history_seconds of the arbiter [s]
_MIN_SIGMA = 1e-5  # keeps the covariance of a stationary robot invertible [m, rad]


def messages_of(samples: Sequence[Sequence[PoseSample]], odometry: Sequence[tuple[int, SE2]]) -> list[Message]:
    """Return the messages of some sources and of odometry in the order of their stamps."""
    content: list[Message] = [(o.stamp, number, o) for number, source in enumerate(samples) for o in source]
    content += [(stamp, ODOMETRY, pose) for stamp, pose in odometry]
    return sorted(content, key=lambda message: (message[0], -message[1]))


def new_arbiter(sources: int) -> Arbiter:
    """Return an arbiter with default settings for a number of sources."""
    return Arbiter((SourceSettings(),) * sources, ArbiterSettings())


def add_message(arbiter: Arbiter, message: Message, now: int) -> None:
    """Add a message to an arbiter.

    Raises:
        ValueError: the arbiter rejected it.
    """
    stamp, source, content = message
    if isinstance(content, SE2):
        refusal = arbiter.add_odometry(stamp, content, now)
    else:
        refusal = arbiter.add_pose(source, stamp, content.pose, content.noise, now)
    if refusal is not None:
        raise ValueError(f'{source} at {stamp}: {refusal.value}')


def in_order_of_arrival(messages: Sequence[Message], delay_of: Callable[[int], int]) -> list[tuple[int, Message]]:
    """Return messages with their times of arrival [ns], sorted by these; a source's poses are late, odometry is not."""
    arrivals = [(m[0] + (0 if m[1] == ODOMETRY else delay_of(m[1])), m) for m in messages]
    return sorted(arrivals, key=lambda each: each[0])


def fused(messages: Sequence[Message], sources: int, wanted: int) -> list[tuple[int, SE2]]:
    """Return stamp and pose right after each message of the wanted source, where there is one."""
    arbiter, poses = new_arbiter(sources), []
    for message in messages:
        add_message(arbiter, message, message[0])
        if message[1] == wanted and (estimate := arbiter.estimate_at(message[0])) is not None:
            poses.append((message[0], estimate.pose))
    return poses


def smooth(
    gtsam: Any, sources: Sequence[Sequence[PoseSample]], odometry: Sequence[tuple[int, SE2]], wanted: int
) -> list[tuple[int, SE2]]:
    """Return the newest state of gtsam's fixed-lag smoother after each pose of a source, with the arbiter's noise."""
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
            origin = initialize(odometry_before, SE2(0.0, 0.0, 0.0), np.zeros((3, 3)), 0)
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
    return gtsam.noiseModel.Gaussian.Covariance(R @ covariance @ R.T + sigma_min**2 * np.eye(3))
