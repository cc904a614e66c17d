"""Subscriptions of the arbiter: poses of the sources, odometry and the initial pose."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node

from pose_arbiter.core.arbiter import PERSON, Arbiter
from pose_arbiter.core.covariance import Covariance
from pose_arbiter.core.source_settings import SourceSettings
from pose_arbiter.core.verdict import Refusal
from pose_arbiter.node_settings import NodeSettings
from pose_arbiter.stamp_conversion import nanoseconds
from shirube_ros.message_error import MessageError
from shirube_ros.message_guard import MessageGuard
from shirube_ros.pose_conversion import planar_pose, planar_pose_with_covariance
from shirube_ros.quality_of_service import odometry_profile, overridable, pose_profile

ODOMETRY, INITIAL_POSE = 'odom', 'initialpose'
_REMEDIES = {
    Refusal.NOT_FINITE: 'check its publisher',
    Refusal.FAR: 'check its publisher',
    Refusal.BAD_COVARIANCE: 'let its publisher fill in the covariance, or set with_covariance to false',
    Refusal.NO_STAMP: 'let its publisher set header.stamp',
    Refusal.FUTURE: 'synchronize the clocks, and set use_sim_time of all nodes to the same value',
    Refusal.TOO_OLD: 'set use_sim_time of all nodes to the same value, or raise history_seconds',
    Refusal.DUPLICATE: 'give each message its own stamp, and each topic one publisher',
}


class ArbiterInput:
    """Subscribes and passes messages to the arbiter."""

    def __init__(
        self,
        node: Node,
        guard: MessageGuard,
        arbiter: Arbiter,
        sources: dict[str, SourceSettings],
        frames: NodeSettings,
        now: Callable[[], int],
    ) -> None:
        """Subscribe.

        Args:
            node: node that subscribes.
            guard: counts received and rejected messages by source name.
            arbiter: receives the poses and odometry.
            sources: settings of the sources, by name.
            frames: required frames of the initial pose and of odometry.
            now: returns the current time [ns], 0 before the first /clock; checks for clock jumps.
        """
        self._arbiter, self._now = arbiter, now
        self._map_frame, self._odom_frame = frames.map_frame, frames.odom_frame
        self.twist: Any = None  # twist of the latest odometry message
        for number, (name, source) in enumerate(sources.items()):
            kind = PoseWithCovarianceStamped if source.with_covariance else PoseStamped
            take = partial(self._take_pose, number, name, source)
            self._subscribe(node, kind, source.topic, guard.guard(name, take), pose_profile())
        odometry = guard.guard(ODOMETRY, self._take_odometry)
        self._subscribe(node, Odometry, ODOMETRY, odometry, odometry_profile())
        person = guard.guard(INITIAL_POSE, self._take_initial_pose)
        self._subscribe(node, PoseWithCovarianceStamped, INITIAL_POSE, person, pose_profile())

    def _subscribe(
        self, node: Node, kind: Any, topic: str, take: Callable[[Any], None], profile: Any
    ) -> None:
        node.create_subscription(kind, topic, take, profile, qos_overriding_options=overridable())

    def _take_pose(self, number: int, name: str, source: SourceSettings, message: Any) -> None:
        if message.header.frame_id != source.frame:
            raise MessageError(
                f'poses of {name} have frame_id {message.header.frame_id!r}, expected '
                f'{source.frame!r}; set {name}.frame or map_frame'
            )
        noise = None
        if source.with_covariance:
            pose, covariance = planar_pose_with_covariance(message.pose, name)
            noise = six_numbers(covariance)
        else:
            pose = planar_pose(message.pose, name)
        stamp = nanoseconds(message.header.stamp)
        _raise(name, self._arbiter.add_pose(number, stamp, pose, noise, self._time()))

    def _take_odometry(self, message: Odometry) -> None:
        if message.header.frame_id not in ('', self._odom_frame):
            raise MessageError(
                f'odometry has frame_id {message.header.frame_id!r}, expected '
                f'{self._odom_frame!r}; set odom_frame'
            )
        stamp = nanoseconds(message.header.stamp)
        pose = planar_pose(message.pose.pose, ODOMETRY)
        _raise(ODOMETRY, self._arbiter.add_odometry(stamp, pose, self._time()))
        self.twist = message.twist

    def _take_initial_pose(self, message: PoseWithCovarianceStamped) -> None:
        if message.header.frame_id not in ('', self._map_frame):
            raise MessageError(
                f'{INITIAL_POSE} has frame_id {message.header.frame_id!r}, expected {self._map_frame!r}; '
                'publish it in map_frame'
            )
        pose, covariance = planar_pose_with_covariance(message.pose, INITIAL_POSE)
        now = self._time()
        stamp = nanoseconds(message.header.stamp) or now
        _raise(INITIAL_POSE, self._arbiter.add_pose(PERSON, stamp, pose, six_numbers(covariance), now))

    def _time(self) -> int:
        """Return the current time [ns]; without it no stamp can be checked.

        Raises:
            MessageError: simulated time has not started.
        """
        now = self._now()
        if now == 0:
            raise MessageError('simulated time has not started; publish /clock, or set use_sim_time to false')
        return now


def six_numbers(covariance: Any) -> Covariance:
    """Return a covariance, shape (3, 3), as the six floats of the core."""
    (xx, xy, xt), (_, yy, yt), (_, _, tt) = covariance.tolist()
    return (xx, xy, xt, yy, yt, tt)


def _raise(name: str, refusal: Refusal | None) -> None:
    if refusal is not None:
        raise MessageError(f'{name}: {refusal.value}; {_REMEDIES[refusal]}')
