"""The ROS node collision_monitor: limits cmd_vel_in by fresh ranges and publishes cmd_vel."""

import json
from typing import Any

import numpy as np
from geometry_msgs.msg import Point32, PolygonStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from std_msgs.msg import Header, String

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.safety.collision_monitor import Action, CollisionMonitor, Decision
from reward_planner.core.safety.compile_kernels import compile_kernels
from reward_planner.core.safety.footprint import convex_hull
from reward_planner.core.safety.safety_settings import CollisionMonitorSettings, SourceSettings
from reward_planner.interface.monitor_inputs import MonitorInput, MonitorNodeSettings, declare_sources
from shirube_core.geometry import SE2
from shirube_ros.diagnostics import Level, Status
from shirube_ros.input_watch import Need
from shirube_ros.managed_node import ManagedNode
from shirube_ros.message_conversion import planar_pose
from shirube_ros.node import run_node
from shirube_ros.quality_of_service import odometry_profile, pose_profile
from shirube_ros.velocity_publisher import VelocityPublisher

_ZONE_PERIOD = 0.2  # period of the published zones [s]
_CYCLE, _TIMER, _ZONES, _COMMAND = 'decision', 'timer', 'zones', 'cmd_vel_in'


class CollisionMonitorNode(ManagedNode):
    """Passes velocities on, limited so that the robot stands before it touches what its range sensors see.

    No certified safety function. Subscribes to ``cmd_vel_in`` (TwistStamped, or Twist with ``stamped:=false``), the
    sources, and optionally ``odom``. Publishes ``cmd_vel`` of the same type, ``~/state`` (String, JSON), the zones
    ``~/stop_zone`` and ``~/slow_down_zone`` (PolygonStamped) and ``/diagnostics``.
    """

    SETTINGS = (MonitorNodeSettings, CollisionMonitorSettings)
    ERRORS = (RewardPlannerError,)

    def __init__(self, **options: Any) -> None:
        """Declare the parameters, and start; options are those of ``rclpy.node.Node``.

        Raises:
            SettingsError: an invalid parameter.
            RewardPlannerError: contradictory parameters.
        """
        super().__init__('collision_monitor', **options)
        self.start()

    def declare_settings(self) -> None:
        """Declare the parameters, also those of the sources."""
        super().declare_settings()
        self._source_class = declare_sources(self)

    def check_settings(self) -> None:
        """Raise a RewardPlannerError for contradictory limits or an invalid footprint."""
        CollisionMonitor(self.settings(CollisionMonitorSettings), self._source_settings())

    def _source_settings(self) -> dict[str, SourceSettings]:
        return dict(vars(self.settings(self._source_class)))

    def configure(self) -> None:
        """Compile the kernels and subscribe."""
        self._settings, self._limits = (self.settings(MonitorNodeSettings), self.settings(CollisionMonitorSettings))
        sources = self._source_settings()
        self._monitor = CollisionMonitor(self._limits, sources)
        self.get_logger().info('compiling numba kernels (first start only)')
        compile_kernels()
        self._is_commanded = False
        self._decision = Decision(0.0, 0.0, Action.FAULT, 'no cmd_vel_in yet')
        base_frame, stamped = self._settings.base_frame, self._settings.stamped
        self._cmd_vel = VelocityPublisher(self, 'cmd_vel', base_frame, stamped=stamped)
        self._state = self.create_publisher(String, '~/state', pose_profile())
        self._zones = [
            self.create_publisher(PolygonStamped, f'~/{name}', pose_profile())
            for name in ('stop_zone', 'slow_down_zone')
        ]
        for name, source in sources.items():
            MonitorInput(self, self._monitor, (name, source, base_frame), self._run)
        kind = TwistStamped if stamped else Twist
        self.subscribe(kind, _COMMAND, self._take_command, pose_profile(), Need.COMMAND)
        self.subscribe(Odometry, 'odom', self._take_odometry, odometry_profile(), Need.OPTIONAL)
        self.create_guarded_timer(1.0 / self._limits.rate, _TIMER, self._run)
        self.create_guarded_timer(_ZONE_PERIOD, _ZONES, self._publish_zones)

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
            self._monitor.refuse_command('cmd_vel_in moves sideways, which is not supported; set linear.y to 0')
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

    def status(self) -> Status:
        """Return the decision and the state of each source."""
        decision = self._decision
        level = Level.WARN if decision.action in (Action.FAULT, Action.STOP) else Level.OK
        now = self._now()
        values = {name: source.fault(now) or 'valid' for name, source in self._monitor.sources.items()}
        values['action'] = decision.action.value
        return Status(level, decision.reason, values)

    def halt(self) -> None:
        """Stop the robot when the node is deactivated or ends."""
        self._cmd_vel.stop()


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node('collision_monitor', CollisionMonitorNode)
