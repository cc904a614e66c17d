"""The ROS node: obstacle mapping, planning and path following."""

import sys
from dataclasses import replace
from typing import Any

from geometry_msgs.msg import PoseStamped
from std_msgs.msg import Header, String

from reward_planner.core.compile_kernels import compile_kernels
from reward_planner.core.driving.drive_state import DriveCommand, DriveState, Velocity
from reward_planner.core.driving.light_command import parse_light_command
from reward_planner.core.driving.recovery import parse_recovery
from reward_planner.core.mapping.pose_buffer import PoseStatus
from reward_planner.core.navigator import Navigator, NavigatorSettings, SensorFrame
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.settings import (
    DrivingSettings,
    MappingSettings,
    PlannerSettings,
    RewardSettings,
    VoxelSettings,
    check_planner_settings,
)
from reward_planner.core.voxels.rolling_voxel_grid import check_voxel_settings
from reward_planner.interface.compute_path_server import PlanningThread, create_compute_path_server
from reward_planner.interface.map_server import MapServer, load_static_map
from reward_planner.interface.navigation_server import NavigationServer
from reward_planner.interface.planner_output import PlannerReport, RoutePublisher
from reward_planner.interface.sensor_inputs import DepthInput, PointsInput, TrinocularInput
from reward_planner.node_settings import NodeSettings, check_source
from shirube_core.geometry import SE2
from shirube_ros.callback_guard import create_trigger_service
from shirube_ros.diagnostics import Status
from shirube_ros.frames import Frames
from shirube_ros.input_watch import Need
from shirube_ros.managed_node import ManagedNode
from shirube_ros.message_conversion import planar_pose
from shirube_ros.node import run_node
from shirube_ros.quality_of_service import pose_profile
from shirube_ros.stamps import StampSynchronizer, StampValidator
from shirube_ros.velocity_publisher import VelocityPublisher

_DRIVE_PERIOD = 0.05  # control period [s]
_MAP_PERIOD = 1.0  # publishing period of the map [s]
_CONTROL = 'control loop'  # its name in the diagnostics


class RewardPlannerNode(ManagedNode):
    """Maps obstacles, plans a route to the goal and, with ``drive``, follows it.

    =========================  ======================  ===================================================
    subscribed                 type                    use
    =========================  ======================  ===================================================
    ``points``                 PointCloud2             obstacles (``source`` points)
    ``depth/image``            Image                   the same (``source`` depth), with ``depth/camera_info``
    ``left/image_rect``, ...   Image                   the same (``source`` trinocular): left, right, top
    ``pose``                   PoseStamped             pose of the robot in ``map_frame``
    ``goal_pose``              PoseStamped             goal in ``map_frame``
    ``command``                String                  commands of lamps, as vlc_beacon publishes them
    =========================  ======================  ===================================================

    =========================  ======================  ===================================================
    published                  type                    when
    =========================  ======================  ===================================================
    ``~/map``                  OccupancyGrid           once a second, if it changed; transient local
    ``~/local_map``            OccupancyGrid           each frame; transient local
    ``~/plan``                 Path                    each new route, empty if there is none; transient local
    ``~/moving_obstacles``     MarkerArray             what moves and is tracked
    ``~/next_waypoint``        PoseStamped             lookahead point, with each velocity on the route
    ``cmd_vel``                TwistStamped            with ``drive``, 20 times a second
    ``/diagnostics``           DiagnosticArray         once a second
    =========================  ======================  ===================================================

    Services (Trigger): ``~/cancel`` the goal, ``~/clear_map``, ``~/save_map`` to a file. If nav2_msgs is
    installed, the node also serves Nav2's actions ``compute_path_to_pose``, ``navigate_to_pose`` and ``follow_path``.
    """

    SETTINGS = (NodeSettings, VoxelSettings, MappingSettings, PlannerSettings, RewardSettings, DrivingSettings)
    ERRORS = (RewardPlannerError,)

    def __init__(self, **options: Any) -> None:
        """Declare the parameters, and start; options are those of ``rclpy.node.Node``.

        Raises:
            SettingsError: an invalid parameter.
            RewardPlannerError: an invalid map or contradictory parameters.
        """
        super().__init__('reward_planner', **options)
        self.start()

    def check_settings(self) -> None:
        """Raise a RewardPlannerError for contradictory parameters."""
        check_source(self.settings(NodeSettings))
        check_planner_settings(self.settings(PlannerSettings))
        check_voxel_settings(self.settings(VoxelSettings))
        parse_recovery(self.settings(DrivingSettings).recovery)

    def _navigator_settings(self) -> NavigatorSettings:
        return NavigatorSettings(
            self.settings(VoxelSettings),
            self.settings(MappingSettings),
            self.settings(PlannerSettings),
            self.settings(RewardSettings),
            self.settings(DrivingSettings),
        )

    def configure(self) -> None:
        """Load the map, if map_file is set, and subscribe."""
        self._settings, method = self.settings(NodeSettings), self._navigator_settings()
        self._navigator = Navigator(self._settings.mount, method)
        self._planning = PlanningThread(is_used=self._settings.planning_thread)
        self._navigator.controller.run_planning = self._planning.run
        warning = load_static_map(self._navigator, self._settings)
        if warning:
            self.get_logger().warning(warning)
        self.get_logger().info('compiling numba kernels (first start only, about 1 min)')
        compile_kernels(self._settings.mount, method)
        self._logged_state: tuple[DriveState, str] | None = None
        self._stamps = StampValidator(self._handle_time_jump, self._now)
        self._frames = Frames(self, self._settings.base_frame)
        self._groups = self._subscribe_to_source()
        self._subscribe()
        self._report = PlannerReport(self._navigator, self._now, method.driving.map_timeout, self._groups)
        self._maps = MapServer(self, self._guard, self._navigator, self._settings)
        self._route = RoutePublisher(self, self._navigator, self._map_header)
        is_driver, base_frame = self._settings.drive, self._settings.base_frame
        self._cmd_vel = VelocityPublisher(self, 'cmd_vel', base_frame) if is_driver else None
        for period, work in ((_DRIVE_PERIOD, self._run_cycle), (_MAP_PERIOD, self._maps.publish_map)):
            self.create_guarded_timer(period, _CONTROL, work)
        plan = self._navigator.route_between
        create_trigger_service(self, self._guard, '~/cancel', self._cancel)
        create_compute_path_server(self, self._guard, self._in_map, plan, self._planning.run)
        refusal = '' if is_driver else 'drive is false'
        self._actions = NavigationServer(self, self._guard, self._navigator, self._drive_to, refusal)

    def apply_settings(self) -> None:
        """Use changed settings from the next frame and control cycle on."""
        settings, method = self.settings(NodeSettings), self._navigator_settings()
        self._navigator.apply_settings(settings.mount, method)
        if self._points is not None:
            self._points.mount = settings.mount
        self._report.frame_period_max = method.driving.map_timeout
        self._settings = settings

    def status(self) -> Status:
        """Return the state of the controller and counters."""
        return self._report.status()

    def _subscribe_to_source(self) -> StampSynchronizer[Any] | None:
        """Subscribe to the source; return the synchronizer of its images, if it has one."""
        self._points: PointsInput | None = None
        match self._settings.source:
            case 'depth':
                DepthInput(self, self._guard, self.settings(VoxelSettings), self._take_frame)
                for topic in ('depth/image', 'depth/camera_info'):
                    self._inputs.add(topic, Need.REQUIRED)
            case 'trinocular':
                for name in ('left', 'right', 'top'):
                    self._inputs.add_images(f'{name}/image_rect', f'{name}/camera_info')
                return TrinocularInput(self, self._guard, self._settings, self._take_frame).groups
            case _:
                self._points = PointsInput(self, self._guard, self._settings, self._frames, self._take_frame)
                self._inputs.add('points', Need.REQUIRED)
        return None

    def _subscribe(self) -> None:
        for kind, topic, take, need in (
            (PoseStamped, 'pose', self._take_pose, Need.REQUIRED),
            (PoseStamped, 'goal_pose', lambda goal: self._drive_to(goal, 'goal_pose'), Need.REQUEST),
            (String, 'command', self._take_command, Need.REQUEST),
        ):
            self.subscribe(kind, topic, take, pose_profile(), need)

    def _now(self) -> float:
        return float(self.get_clock().now().nanoseconds * 1e-9)

    def _map_header(self) -> Header:
        return Header(stamp=self.get_clock().now().to_msg(), frame_id=self._settings.map_frame)

    def _take_frame(self, header: Header, frame: SensorFrame) -> None:
        stamp = self._stamps.check(header, self._settings.source)
        if frame.mount is None:
            frame = replace(frame, mount=self._frames.mount(header, self._settings.mount))
        self._navigator.add_frame(stamp, self._now(), frame)

    def _take_pose(self, message: PoseStamped) -> None:
        pose = self._in_map(message, 'pose', is_latest_valid=False)
        status = self._navigator.add_pose(self._stamps.check(message.header, 'pose'), pose)
        if status is PoseStatus.JUMPED:
            self.get_logger().warning(
                'the pose jumped; the robot stops until its poses are consistent again', throttle_duration_sec=1.0
            )
        elif status is PoseStatus.RELOCATED:
            self.get_logger().warning(f'poses are consistent again, at x {pose.x:.2f} m, y {pose.y:.2f} m')

    def _drive_to(self, message: PoseStamped, topic: str, path: list[PoseStamped] | None = None) -> None:
        goal = self._in_map(message, topic)
        self._navigator.set_goal(goal, None if path is None else [self._in_map(each, topic) for each in path])

    def _cancel(self) -> str:
        self._navigator.controller.cancel_goal()
        return 'goal cancelled'

    def _in_map(self, message: PoseStamped, topic: str, *, is_latest_valid: bool = True) -> SE2:
        header, map_frame = message.header, self._settings.map_frame
        refusal = f'{topic} is in the frame {header.frame_id!r}, map_frame is {map_frame!r}; make them the same'
        pose = planar_pose(message.pose, topic)
        return self._frames.pose_to(map_frame, header, pose, refusal, is_latest_valid=is_latest_valid)

    def _take_command(self, message: String) -> None:
        command = parse_light_command(message.data)
        self._navigator.controller.apply_command(command)
        self.get_logger().info(f'command of a lamp: {command.operation} {command.value:g}')

    def _run_cycle(self) -> None:
        """Map queued frames and run the drive controller, which runs even after an invalid frame."""
        now = self._now()
        try:
            for frame in self._navigator.process_frames(now):
                self._report.add_frame(frame)
                self._maps.publish_local_map(frame)
        finally:
            self._drive(now)

    def _drive(self, now: float) -> None:
        try:
            drive = self._navigator.controller.step(now)
        except Exception:
            self._send(Velocity())  # otherwise the motors would keep the last velocity until their timeout
            raise
        self._report.add_drive(drive)
        self._actions.update(drive, now)
        self._log_state(drive)
        self._route.publish(drive)
        if drive.velocity is not None:
            self._send(drive.velocity)

    def _send(self, velocity: Velocity) -> None:
        if self._cmd_vel is not None:
            self._cmd_vel.send(velocity.forward, velocity.turn_rate)

    def halt(self) -> None:
        """Stop the robot and cancel its goal."""
        self._actions.end('UNKNOWN', 'the node was deactivated')
        self._navigator.controller.halt()
        self._planning.end()
        if self._cmd_vel is not None:
            self._cmd_vel.stop()

    def _log_state(self, drive: DriveCommand) -> None:
        """Log a line when the state of the controller changes."""
        if self._logged_state == (drive.state, drive.detail):
            return
        self._logged_state = (drive.state, drive.detail)
        logger = self.get_logger()
        if drive.state.needs_attention:
            logger.warning(drive.detail)
        else:
            logger.info(drive.detail)

    def _handle_time_jump(self) -> None:
        self.get_logger().warning(
            'clock jumped back: poses, queued frames and the goal were reset, the robot stops; the map stays'
        )
        self._navigator.handle_time_jump()
        if self._groups is not None:
            self._groups.clear()


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node('reward_planner', RewardPlannerNode)


if __name__ == '__main__':
    sys.exit(main())
