"""The ROS node collision_monitor: limits cmd_vel_in by fresh ranges and publishes cmd_vel."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from geometry_msgs.msg import Point32, PolygonStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from rclpy.node import Node
from std_msgs.msg import Header, String

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.safety.collision_monitor import Action, CollisionMonitor, Decision
from reward_planner.core.safety.compile_kernels import compile_kernels
from reward_planner.core.safety.footprint import convex_hull
from reward_planner.core.safety.safety_settings import CollisionMonitorSettings
from reward_planner.interface.monitor_inputs import MonitorInput
from reward_planner.interface.monitor_settings import MonitorNodeSettings, declare_sources
from shirube_core.geometry import SE2
from shirube_ros.callback_guard import CallbackGuard
from shirube_ros.diagnostics import Diagnostics, Level, Status
from shirube_ros.node import run_node
from shirube_ros.parameters import declare_parameters, reject_misspelled_parameters
from shirube_ros.pose_conversion import planar_pose
from shirube_ros.quality_of_service import odometry_profile, overridable, pose_profile
from shirube_ros.velocity_publisher import VelocityPublisher

_ZONE_PERIOD = 0.2  # period of the published zones [s]
_CYCLE, _COMMAND = 'decision', 'cmd_vel_in'


class CollisionMonitorNode(Node):
    """Passes velocities on, limited so that the robot stands before it touches what its range sensors see.

    No certified safety function. Subscribes to ``cmd_vel_in`` (TwistStamped, or Twist with ``stamped:=false``), the
    sources, and optionally ``odom``. Publishes ``cmd_vel`` of the same type, ``~/state`` (String, JSON), the zones
    ``~/stop_zone`` and ``~/slow_down_zone`` (PolygonStamped) and ``/diagnostics``.
    """

    def __init__(self, **options: Any) -> None:
        """Subscribe; options are those of ``rclpy.node.Node``.

        Raises:
            SettingsError: an invalid parameter.
            RewardPlannerError: contradictory parameters.
        """
        super().__init__('collision_monitor', **options)
        self._settings = declare_parameters(self, MonitorNodeSettings)
        self._limits = declare_parameters(self, CollisionMonitorSettings)
        sources = declare_sources(self)
        reject_misspelled_parameters(self)
        self._monitor = CollisionMonitor(self._limits, sources)
        self.get_logger().info('compiling numba kernels (first start only)')
        compile_kernels()
        self._guard = CallbackGuard(self, (RewardPlannerError,))
        self._is_commanded = False
        self._decision = Decision(0.0, 0.0, Action.FAULT, 'no cmd_vel_in yet')
        base_frame, stamped = self._settings.base_frame, self._settings.stamped
        self._cmd_vel = VelocityPublisher(self, 'cmd_vel', base_frame, stamped=stamped)
        self._state = self.create_publisher(String, '~/state', pose_profile())
        self._zones = [
            self.create_publisher(PolygonStamped, f'~/{name}', pose_profile())
            for name in ('stop_zone', 'slow_down_zone')
        ]
        self._inputs = [
            MonitorInput(self, self._guard, self._monitor, (name, source, base_frame), self._run)
            for name, source in sources.items()
        ]
        kind = TwistStamped if stamped else Twist
        self._subscribe(kind, _COMMAND, self._take_command, pose_profile())
        self._subscribe(Odometry, 'odom', self._take_odometry, odometry_profile())
        for period, work in ((1.0 / self._limits.rate, self._run), (_ZONE_PERIOD, self._publish_zones)):
            self.create_timer(period, work)
        self._diagnostics = Diagnostics(self, self._guard.counts, self._status)

    def _subscribe(self, kind: type, topic: str, take: Any, profile: Any) -> None:
        guarded = self._guard.guard(topic, take)
        self.create_subscription(kind, topic, guarded, profile, qos_overriding_options=overridable())

    def _now(self) -> float:
        return float(self.get_clock().now().nanoseconds * 1e-9)

    def _take_command(self, message: TwistStamped | Twist) -> None:
        self._is_commanded = True
        twist = message.twist if isinstance(message, TwistStamped) else message
        now, sent = self._now(), self._now()
        if isinstance(message, TwistStamped) and (message.header.stamp.sec or message.header.stamp.nanosec):
            sent = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
        if abs(now - sent) > self._limits.command_timeout:
            self._monitor.refuse_command('cmd_vel_in has an old or future stamp; synchronize the clocks')
        if twist.linear.y != 0.0:
            self._monitor.refuse_command(
                'cmd_vel_in moves sideways, which is not supported; set linear.y to 0'
            )
        self._monitor.add_command(min(now, sent), twist.linear.x, twist.angular.z)
        self._run()

    def _take_odometry(self, message: Odometry) -> None:
        stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
        self._monitor.add_odometry(stamp, planar_pose(message.pose.pose, 'odom'))

    def _run(self) -> None:
        """Decide and publish; whatever goes wrong, the robot stops."""
        if self._guard.run(_CYCLE, self._decide) is not None:
            self._decision = Decision(0.0, 0.0, Action.FAULT, 'internal error, see the log')
        if self._is_commanded:
            self._cmd_vel.send(self._decision.forward, self._decision.turn_rate)

    def _decide(self) -> None:
        before, self._decision = self._decision, self._monitor.decide(self._now())
        if (before.action, before.reason) == (self._decision.action, self._decision.reason):
            return
        line = f'{self._decision.action.value}: {self._decision.reason}'
        if self._decision.action is Action.FAULT:
            self.get_logger().warning(line, throttle_duration_sec=0.5)
        else:
            self.get_logger().info(line, throttle_duration_sec=0.5)

    def _publish_zones(self) -> None:
        decision = self._decision
        names = ('reason', 'source', 'fraction', 'forward', 'turn_rate')
        values = {'action': decision.action.value} | {name: getattr(decision, name) for name in names}
        self._state.publish(String(data=json.dumps(values)))
        margin, paths = self._limits.stop_margin, (self._monitor.path, self._monitor.slow_path)
        for publisher, path, more in zip(self._zones, paths, (0.0, self._limits.slow_margin), strict=True):
            outline = self._monitor.footprint.inflated(margin + more)
            places = [SE2(x, y, yaw).transform(outline) for x, y, yaw in path.tolist()]
            publisher.publish(self._polygon(convex_hull(np.concatenate(places))))

    def _polygon(self, corners: NDArray[np.float64]) -> PolygonStamped:
        header = Header(stamp=self.get_clock().now().to_msg(), frame_id=self._settings.base_frame)
        message = PolygonStamped(header=header)
        message.polygon.points = [Point32(x=x, y=y) for x, y in corners.tolist()]
        return message

    def _status(self) -> Status:
        decision = self._decision
        level = Level.WARN if decision.action in (Action.FAULT, Action.STOP) else Level.OK
        now = self._now()
        values = {name: source.fault(now) or 'valid' for name, source in self._monitor.sources.items()}
        values['action'] = decision.action.value
        return Status(level, decision.reason, values)

    def stop(self) -> None:
        """Stop the robot when the node ends."""
        self._cmd_vel.stop()


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node('collision_monitor', CollisionMonitorNode, (RewardPlannerError,))
