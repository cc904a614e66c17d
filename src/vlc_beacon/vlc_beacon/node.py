"""ROS node: images of the ceiling in; robot pose and lamp commands out."""

import sys
from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, QuaternionStamped
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from sensor_msgs.msg import Image, Imu
from std_msgs.msg import Header, String
from visualization_msgs.msg import MarkerArray

from shirube_core.geometry import CameraMount, PinholeCamera
from shirube_ros.camera.image import image_from_array
from shirube_ros.camera.info import camera_from_camera_info
from shirube_ros.camera.input import ImageInput
from shirube_ros.diagnostics import Status
from shirube_ros.frames import Frames
from shirube_ros.input_watch import Need
from shirube_ros.managed_node import ManagedNode
from shirube_ros.message_conversion import (
    base_odometry,
    pose_stamped,
    pose_with_covariance_stamped,
    tilt_from_imu,
    tilt_from_quaternion,
)
from shirube_ros.node import run_node
from shirube_ros.quality_of_service import odometry_profile, pose_profile
from shirube_ros.stamps import StampValidator
from shirube_ros.velocity_publisher import VelocityPublisher
from vlc_beacon.core.authorization.command_authorizer import Accepted, CommandAuthorizer
from vlc_beacon.core.command_executor import CommandExecutor
from vlc_beacon.core.packet.command_packet import Operation
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.pose.pose_fix import BeaconFix, NoBeaconFix
from vlc_beacon.core.receiver.beacon_receiver import BeaconReceiver, ReceiverOutput
from vlc_beacon.core.receiver.command_processor import CommandDecision
from vlc_beacon.core.receiver.compile_kernels import compile_kernels
from vlc_beacon.core.settings import AuthorizationSettings, ReceiverSettings
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError
from vlc_beacon.node_output import ReceiverDiagnostics, beacon_markers, draw_debug_image
from vlc_beacon.node_settings import NodeSettings, authorizer_from_settings, beacons_from_settings

_LOG_INTERVAL = 1.0
"""Minimum interval between log lines about found and lost poses [s]."""
_DRIVE_PERIOD = 0.05
"""Period of velocity commands [s]."""

CreateReceiver = Callable[[list[Beacon], CameraMount, CommandAuthorizer, ReceiverSettings], BeaconReceiver]


def create_compiled_receiver(
    beacons: list[Beacon], mount: CameraMount, authorizer: CommandAuthorizer, settings: ReceiverSettings
) -> BeaconReceiver:
    """Return a receiver with compiled numba kernels."""
    receiver = BeaconReceiver(beacons, mount, authorizer, settings)
    compile_kernels(settings)
    return receiver


class VlcBeaconNode(ManagedNode):
    """Publishes the robot's pose and the received commands, from lamps seen by an upward camera.

    =========================  ============================  =============================================
    subscribed                 type                          use
    =========================  ============================  =============================================
    ``image_raw``              Image or CompressedImage      the ceiling (``image_transport``)
    ``camera_info``            CameraInfo                    its calibration
    ``imu``                    Imu                           optional: tilt of ``base_frame``
    ``attitude``               QuaternionStamped             optional: the same
    ``odom``                   Odometry                      optional: dead reckoning between lamps
    =========================  ============================  =============================================

    =========================  ============================  =============================================
    published                  type                          when
    =========================  ============================  =============================================
    ``~/pose``                 PoseStamped                   each image with a fix
    ``~/pose_with_covariance`` PoseWithCovarianceStamped     each image with a fix
    ``~/command``              String                        each command that is accepted, as JSON
    ``~/data``                 String                        each received text or bytes, as JSON
    ``~/cmd_vel``              TwistStamped                  with ``drive``, 20 times a second
    ``~/beacons``              MarkerArray                   while subscribed
    ``~/debug_image``          Image                         while subscribed
    ``/diagnostics``           DiagnosticArray               once a second
    =========================  ============================  =============================================
    """

    SETTINGS = (NodeSettings, ReceiverSettings, AuthorizationSettings)
    ERRORS = (VlcBeaconError,)

    def __init__(self, create_receiver: CreateReceiver = create_compiled_receiver, **options: Any) -> None:
        """Declare the parameters, and start.

        Args:
            create_receiver: factory of the receiver, called at the start and after a jump back in time.
            options: options of ``rclpy.node.Node``.

        Raises:
            SettingsError: invalid parameter.
            VlcBeaconError: invalid file.
        """
        super().__init__('vlc_beacon', **options)
        self._create_receiver = create_receiver
        self.start()

    def configure(self) -> None:
        """Load beacons, key and counters, and subscribe."""
        self._settings = self.settings(NodeSettings)
        self._beacons = beacons_from_settings(self._settings)
        self._authorizer = authorizer_from_settings(self._settings, self.settings(AuthorizationSettings), self._beacons)
        self._mount = self._settings.mount
        self._receiver = self._new_receiver()
        self._frames = Frames(self, self._settings.base_frame)
        self._had_fix: bool | None = None
        self._command_executor = self._new_executor()
        self._report = ReceiverDiagnostics(self._settings.beacons_file, self._authorizer)
        self._stamps = StampValidator(self._reset)
        self._create_publishers()
        self._create_subscriptions()
        rejection = self._authorizer.permanent_rejection
        if rejection is not None:
            self.get_logger().warning(rejection.message)

    def apply_settings(self) -> None:
        """Use changed settings from the next image on."""
        settings, authorization = self.settings(NodeSettings), self.settings(AuthorizationSettings)
        self._receiver.apply_settings(settings.mount, self.settings(ReceiverSettings))
        self._authorizer.apply_settings(authorization)
        if self._command_executor is not None:
            self._command_executor.apply_settings(settings.driving, authorization.speed_limit)
        self._settings, self._mount = settings, settings.mount

    def status(self) -> Status:
        """Return lamps, pose and commands."""
        return self._report.status()

    def _new_receiver(self) -> BeaconReceiver:
        return self._create_receiver(self._beacons, self._mount, self._authorizer, self.settings(ReceiverSettings))

    def _new_executor(self) -> CommandExecutor | None:
        if not self._settings.drive:
            return None
        return CommandExecutor(self._settings.driving, self.settings(AuthorizationSettings).speed_limit)

    def _create_publishers(self) -> None:
        self._pose = self.create_publisher(PoseStamped, '~/pose', pose_profile())
        self._pose_with_covariance = self.create_publisher(
            PoseWithCovarianceStamped, '~/pose_with_covariance', pose_profile()
        )
        self._command = self.create_publisher(String, '~/command', pose_profile())
        self._data = self.create_publisher(String, '~/data', pose_profile())
        self._markers = self.create_publisher(MarkerArray, '~/beacons', pose_profile())
        self._debug_image = self.create_publisher(Image, '~/debug_image', pose_profile())
        self._cmd_vel = None
        if self._settings.drive:
            self._cmd_vel = VelocityPublisher(self, '~/cmd_vel', self._settings.base_frame)
            self.create_guarded_timer(_DRIVE_PERIOD, '~/cmd_vel', self._drive)

    def _drive(self) -> None:
        """Publish the velocity of the command executor."""
        executor = self._command_executor
        velocity = None if executor is None else executor.velocity(self.get_clock().now().nanoseconds * 1e-9)
        if velocity is not None and self._cmd_vel is not None:
            self._cmd_vel.send(velocity.forward, velocity.turn_rate)

    def halt(self) -> None:
        """Stop the robot."""
        if self._command_executor is not None:
            self._command_executor.halt()
        if self._cmd_vel is not None:
            self._cmd_vel.stop()

    def _create_subscriptions(self) -> None:
        topics, transport = ('image_raw', 'camera_info'), self._settings.image_transport
        ImageInput(self, self._guard, topics, transport, camera_from_camera_info, self._on_image)
        self._inputs.add_images(*topics)
        for kind, topic, callback in (
            (Odometry, 'odom', self._on_odometry),
            (Imu, 'imu', self._on_imu),
            (QuaternionStamped, 'attitude', self._on_attitude),
        ):
            self.subscribe(kind, topic, callback, odometry_profile(), Need.OPTIONAL)

    def _on_image(self, header: Header, pixels: NDArray[np.uint8], camera: PinholeCamera) -> None:
        stamp = self._stamps.check(header, 'image_raw')
        mount = self._frames.mount(header, self._settings.mount)
        if mount != self._mount:
            self._receiver.apply_settings(mount, self.settings(ReceiverSettings))
            self._mount = mount
        started = perf_counter()
        output = self._receiver.receive(stamp, pixels, camera)
        self._report.add(output, perf_counter() - started)
        self._log_change(output.result)
        map_header = Header(stamp=header.stamp, frame_id=self._settings.map_frame)
        self._publish(stamp, map_header, output)
        for message in output.messages:
            self.get_logger().info(f'{message.sender_name} sent {message.printable}')
            self._data.publish(String(data=message.to_json()))
        for decision in output.decisions:
            self._on_decision(decision)
        if self._debug_image.get_subscription_count() > 0:
            self._debug_image.publish(image_from_array(draw_debug_image(pixels, output), header))

    def _log_change(self, result: BeaconFix | NoBeaconFix) -> None:
        """Log when the pose is found or lost; details are in the diagnostics."""
        has_fix = isinstance(result, BeaconFix)
        if has_fix == self._had_fix:
            return
        if isinstance(result, NoBeaconFix):
            line = f'no pose: {result.reason.value} ({result.detail})'
        else:
            pose, lamps = result.T_map_base, int(result.used.sum())
            line = f'pose: x {pose.x:.3f} m, y {pose.y:.3f} m, yaw {pose.yaw:.3f} rad from {lamps} lamps'
        # A throttled line is logged with a later image.
        if self.get_logger().info(line, throttle_duration_sec=_LOG_INTERVAL):
            self._had_fix = has_fix

    def _publish(self, stamp: float, header: Header, output: ReceiverOutput) -> None:
        result = output.result
        if isinstance(result, BeaconFix):
            self._pose.publish(pose_stamped(result.T_map_base, header))
            self._pose_with_covariance.publish(
                pose_with_covariance_stamped(result.T_map_base, result.planar_covariance, header)
            )
            if self._command_executor is not None:
                self._command_executor.update_pose(stamp, result.T_map_base)
        if self._markers.get_subscription_count() > 0:
            self._markers.publish(beacon_markers(self._beacons, output, header))

    def _on_decision(self, decision: CommandDecision) -> None:
        outcome = decision.outcome
        if not isinstance(outcome, Accepted):
            # Two calls: rclpy requires one severity per call site.
            if outcome.reason.is_suspicious:
                self.get_logger().warning(f'rejected: {outcome.message}')
            else:
                self.get_logger().info(f'rejected: {outcome.message}')
            return
        self.get_logger().info(f'accepted: {outcome.to_json()}')
        self._command.publish(String(data=outcome.to_json()))
        if self._command_executor is not None:
            self._command_executor.execute(Operation(outcome.command.operation), outcome.command.value)

    def _on_odometry(self, message: Odometry) -> None:
        T_odom_base = base_odometry(message, 'odom', self._settings.base_frame)
        stamp = self._stamps.check(message.header, 'odom')  # may replace the receiver
        self._receiver.add_odometry(stamp, T_odom_base)

    def _on_imu(self, message: Imu) -> None:
        tilt = tilt_from_imu(message, 'imu')
        stamp = self._stamps.check(message.header, 'imu')
        self._receiver.add_tilt(stamp, *tilt)

    def _on_attitude(self, message: QuaternionStamped) -> None:
        tilt = tilt_from_quaternion(message.quaternion, 'attitude')
        stamp = self._stamps.check(message.header, 'attitude')
        self._receiver.add_tilt(stamp, *tilt)

    def _reset(self) -> None:
        self.get_logger().warning('clock jumped back: lamps, pose and odometry were reset')
        self._authorizer.reset_position()
        self._receiver = self._new_receiver()
        before, self._command_executor = self._command_executor, self._new_executor()
        if before is not None and before.is_stopped and self._command_executor is not None:
            # A stop command survives the reset.
            self._command_executor.execute(Operation.STOP, 0.0)


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node('vlc_beacon', VlcBeaconNode)


if __name__ == '__main__':
    sys.exit(main())
