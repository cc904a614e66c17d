"""The ROS node: fuses the poses of all sources and odometry into one pose."""

from __future__ import annotations

import sys
from typing import Any

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from std_msgs.msg import Header

from pose_arbiter.arbiter_input import ArbiterInput
from pose_arbiter.arbiter_report import ArbiterReport
from pose_arbiter.clock_monitor import ClockMonitor
from pose_arbiter.core.arbiter import Arbiter
from pose_arbiter.core.arbiter_settings import ArbiterSettings
from pose_arbiter.core.kalman_filter import Estimate
from pose_arbiter.core.localization_status import localization_status
from pose_arbiter.core.pose_arbiter_error import PoseArbiterError
from pose_arbiter.node_settings import NodeSettings
from pose_arbiter.source_parameters import declare_sources
from pose_arbiter.stamp_conversion import time_message
from pose_arbiter.tick_schedule import TickSchedule
from pose_arbiter.transform_output import TransformOutput
from shirube_core.geometry import SE2
from shirube_ros.callback_guard import CallbackGuard, create_trigger_service
from shirube_ros.diagnostics import Diagnostics
from shirube_ros.node import run_node
from shirube_ros.parameters import declare_parameters, reject_misspelled_parameters
from shirube_ros.pose_conversion import odometry_message, pose_stamped
from shirube_ros.quality_of_service import pose_profile

_OUTPUT = 'output'  # name of the timer callback in the diagnostics


class PoseArbiterNode(Node):
    """Publishes one pose fused from all sources and odometry.

    =========================  ==========================  ===================================================
    subscribed                 type                        use
    =========================  ==========================  ===================================================
    ``<name>.topic``           PoseWithCovarianceStamped   pose of a source; or PoseStamped (``with_covariance``)
    ``odom``                   Odometry                    motion of the robot between poses
    ``initialpose``            PoseWithCovarianceStamped   pose set by an operator
    =========================  ==========================  ===================================================

    =========================  ==========================  ===================================================
    published                  type                        when
    =========================  ==========================  ===================================================
    ``~/pose``                 PoseStamped                 50 Hz (``rate``), while the pose is known
    ``~/odometry``             Odometry                    with each pose: covariance, and the twist of ``odom``
    ``/tf``                    TFMessage                   with each pose, map to odom (needs tf2_ros)
    ``/diagnostics``           DiagnosticArray             1 Hz
    =========================  ==========================  ===================================================

    Service (Trigger): ``~/reset`` clears the pose and the states of the sources.
    """

    def __init__(self, **options: Any) -> None:
        """Subscribe to the sources.

        Args:
            options: keyword arguments of ``rclpy.node.Node``.

        Raises:
            SettingsError: a bad parameter.
            PoseArbiterError: inconsistent parameters.
        """
        super().__init__('pose_arbiter', **options)
        self._settings = declare_parameters(self, NodeSettings)
        self._filter_settings = declare_parameters(self, ArbiterSettings)
        sources = declare_sources(self, self._settings.map_frame)
        reject_misspelled_parameters(self)
        frames = (self._settings.map_frame, self._settings.odom_frame, self._settings.base_frame)
        if len(set(frames)) < len(frames):
            raise PoseArbiterError(
                'two of map_frame, odom_frame and base_frame are the same; give each frame its own name'
            )
        self._sources = tuple(sources.values())
        self._arbiter = Arbiter(self._sources, self._filter_settings)
        self._clock_monitor = ClockMonitor(self, self._on_clock_jump)
        self._guard = CallbackGuard(self, (PoseArbiterError,))
        self._schedule = TickSchedule(self._settings.rate)
        self._report = ArbiterReport(self, self._arbiter, sources, self._clock_monitor.now)
        self._pose = self.create_publisher(PoseStamped, '~/pose', pose_profile())
        self._odometry = self.create_publisher(Odometry, '~/odometry', pose_profile())
        self._transform = None
        if self._settings.publish_tf:
            self._transform = TransformOutput(self, self._settings.map_frame, self._settings.odom_frame)
        self._input = ArbiterInput(
            self, self._guard, self._arbiter, sources, self._settings, self._clock_monitor.now
        )
        create_trigger_service(self, self._guard, '~/reset', self._reset)
        publish_due = self._guard.guard(_OUTPUT, self._publish_due)
        self.create_timer(1.0 / self._settings.rate, lambda: publish_due(None))
        self._diagnostics = Diagnostics(self, self._guard.counts, self._report.status)

    def _publish_due(self, _: None) -> None:
        """Publish all due poses."""
        for stamp in self._schedule.due(self._clock_monitor.now()):
            state, estimate = self._arbiter.state_at(stamp), self._arbiter.estimate_at(stamp)
            status = localization_status(state, estimate, self._sources, self._filter_settings)
            self._report.observe(state, estimate, status)
            if status.has_pose and estimate is not None:
                self._publish(stamp, estimate)
                self._publish_transform(stamp)

    def _publish(self, stamp: int, estimate: Estimate) -> None:
        header = Header(stamp=time_message(stamp), frame_id=self._settings.map_frame)
        pose = SE2(estimate.x, estimate.y, estimate.yaw)
        self._pose.publish(pose_stamped(pose, header))
        xx, xy, xt, yy, yt, tt = estimate.covariance
        covariance = ((xx, xy, xt), (xy, yy, yt), (xt, yt, tt))
        message = odometry_message(pose, covariance, header, self._settings.base_frame)
        if self._input.twist is not None:
            message.twist = self._input.twist
        self._odometry.publish(message)

    def _publish_transform(self, stamp: int) -> None:
        """Publish map to odom, as computed at the stamp of the latest odometry."""
        latest = self._arbiter.latest_odometry
        if self._transform is None or latest is None:
            return
        estimate = self._arbiter.estimate_at(min(latest, stamp))
        T_map_odom = None if estimate is None else self._arbiter.T_map_odom(estimate)
        if T_map_odom is not None:
            self._transform.send(T_map_odom, stamp + round(1e9 * self._settings.transform_tolerance))

    def _reset(self) -> str:
        self._arbiter.reset()
        return 'pose reset'

    def _on_clock_jump(self) -> None:
        self.get_logger().warning('clock jumped: pose and source history were reset')
        self._arbiter.reset()
        self._schedule.reset()


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node('pose_arbiter', PoseArbiterNode, (PoseArbiterError,))


if __name__ == '__main__':
    sys.exit(main())
