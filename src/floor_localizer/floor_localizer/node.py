"""The ROS node: subscribes to images and odometry, publishes the robot's pose on the map."""

import sys
from collections import Counter
from collections.abc import Callable
from time import perf_counter
from typing import Any

from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image
from std_msgs.msg import Header
from visualization_msgs.msg import MarkerArray

from floor_localizer.core.arrays import Pixels
from floor_localizer.core.dot_extraction.detector import DotDetector
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.fix import Fix, NoFix
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.settings import LocalizerSettings, TrackerSettings
from floor_localizer.core.tracker import FloorTracker
from floor_localizer.localization.localizer_from_map_file import STARTUP_NOTICE, NodeSettings, localizer_from_map_file
from floor_localizer.localization.visualization import debug_picture, delete_markers, dot_markers
from shirube_core.geometry import CameraMount, PinholeCamera
from shirube_ros.callback_guard import create_trigger_service
from shirube_ros.camera.image import image_from_array
from shirube_ros.camera.info import camera_from_camera_info
from shirube_ros.camera.input import ImageInput
from shirube_ros.diagnostics import Level, Status
from shirube_ros.frames import Frames
from shirube_ros.input_watch import Need
from shirube_ros.managed_node import ManagedNode
from shirube_ros.message_conversion import (
    base_odometry,
    planar_pose_with_covariance,
    pose_stamped,
    pose_with_covariance_stamped,
)
from shirube_ros.node import run_node
from shirube_ros.quality_of_service import odometry_profile, pose_profile
from shirube_ros.stamps import StampValidator

_LOG_INTERVAL = 1.0  # minimum interval between log messages about found and lost poses [s]


class LocalizerReport:
    """Stores the latest result and counts all results."""

    def __init__(self, map_name: str) -> None:
        """Start without results."""
        self._map_name = map_name
        self._latest: Fix | NoFix | None = None
        self._duration = 0.0
        self._fixes = 0
        self._no_fixes: Counter[str] = Counter()

    def add(self, result: Fix | NoFix, duration: float) -> None:
        """Add the result of an image and its processing time [s]."""
        self._latest, self._duration = result, duration
        if isinstance(result, Fix):
            self._fixes += 1
        else:
            self._no_fixes[result.reason.value] += 1

    def status(self) -> Status:
        """Return the current status."""
        values = {'map': self._map_name, 'images with a fix': str(self._fixes)}
        for reason, number in self._no_fixes.items():
            values[f'images without: {reason}'] = str(number)
        if self._latest is None:
            return Status(Level.WARN, 'no image received', values)
        values['time for the latest image [ms]'] = f'{1e3 * self._duration:.1f}'
        if isinstance(self._latest, NoFix):
            values |= _no_fix_values(self._latest)
            return Status(Level.WARN, f'no fix: {self._latest.reason.value}', values)
        return Status(Level.OK, 'fix', values | _fix_values(self._latest))


def _no_fix_values(result: NoFix) -> dict[str, str]:
    dots = 0 if result.dots is None else len(result.dots)
    return {'detail': result.detail, 'dots': str(dots)}


def _fix_values(fix: Fix) -> dict[str, str]:
    pose = fix.T_map_base
    sigma_x, sigma_y, sigma_yaw = fix.covariance.diagonal() ** 0.5
    level = {'level': fix.level} if fix.level else {}
    return level | {
        'dots': str(len(fix.dots)),
        'dots matched': str(int(fix.matched.sum())),
        'match rate': f'{fix.match_rate:.3f}',
        'expected chance alignments': f'{fix.expected_chance_alignments:.1e}',
        'searched with a prior': 'yes' if fix.used_prior else 'no',
        'x, y, yaw': f'{pose.x:.4f} m, {pose.y:.4f} m, {pose.yaw:.4f} rad',
        'sigma x, y, yaw': f'{1e3 * sigma_x:.3f} mm, {1e3 * sigma_y:.3f} mm, {1e3 * sigma_yaw:.3f} mrad',
        'camera height over nominal': f'{100.0 * fix.scale:+.2f} %',
        'tilt': f'{1e3 * fix.tilt[0]:.2f} mrad, {1e3 * fix.tilt[1]:.2f} mrad',
    }


class FloorLocalizerNode(ManagedNode):
    """Publishes the robot's pose, from the floor's dots in the images of its belly camera.

    =========================  ============================  =============================================
    subscribed                 type                          use
    =========================  ============================  =============================================
    ``image_raw``              Image or CompressedImage      the floor (``image_transport``)
    ``camera_info``            CameraInfo                    its calibration
    ``odom``                   Odometry                      optional: predicts the pose between images
    ``initialpose``            PoseWithCovarianceStamped     optional: search only there until found
    =========================  ============================  =============================================

    =========================  ============================  =============================================
    published                  type                          when
    =========================  ============================  =============================================
    ``~/pose``                 PoseStamped                   each image with a fix
    ``~/pose_with_covariance`` PoseWithCovarianceStamped     each image with a fix
    ``~/dots``                 MarkerArray                   while there are subscribers
    ``~/debug_image``          Image                         while there are subscribers
    ``/diagnostics``           DiagnosticArray               1 Hz
    =========================  ============================  =============================================

    The service ``~/relocalize`` (Trigger) drops the prior: the next image is searched in the whole map.
    """

    SETTINGS = (NodeSettings, LocalizerSettings)
    ERRORS = (FloorLocalizerError,)

    def __init__(
        self,
        create_localizer: Callable[
            [NodeSettings, LocalizerSettings, Callable[[str], object]], FloorLocalizer
        ] = localizer_from_map_file,
        create_tracker: Callable[[FloorLocalizer, TrackerSettings], FloorTracker] = FloorTracker,
        **options: Any,
    ) -> None:
        """Declare the parameters, and start.

        Args:
            create_localizer: loads the map and compiles the kernels.
            create_tracker: creates the tracker, at start and after a jump back in time.
            options: passed to ``rclpy.node.Node``.

        Raises:
            SettingsError: an invalid parameter.
            FloorLocalizerError: an invalid map.
        """
        super().__init__('floor_localizer', **options)
        self._create_localizer, self._create_tracker = create_localizer, create_tracker
        self.start()

    def configure(self) -> None:
        """Load the map and subscribe."""
        self._settings = self.settings(NodeSettings)
        self._report = LocalizerReport(self._map_name())
        self.get_logger().info(STARTUP_NOTICE)
        self._localizer = self._create_localizer(
            self._settings, self.settings(LocalizerSettings), self.get_logger().info
        )
        self._mount, self._frames = self._settings.mount, Frames(self, self._settings.base_frame)
        self._had_fix: bool | None = None
        self._tracker = self._create_tracker(self._localizer, self._settings.tracker)
        self._stamps = StampValidator(self._reset)
        self._advertise()
        self._subscribe()

    def apply_settings(self) -> None:
        """Use changed settings from the next image on."""
        settings = self.settings(NodeSettings)
        self._use_mount(settings, settings.mount)

    def _use_mount(self, settings: NodeSettings, mount: CameraMount) -> None:
        method, detector = self.settings(LocalizerSettings), DotDetector(settings.dots)
        self._localizer = FloorLocalizer(self._localizer.floor, mount, method, detector)
        self._tracker.apply_settings(self._localizer, settings.tracker)
        self._settings, self._mount = settings, mount

    def status(self) -> Status:
        """Return the latest result."""
        return self._report.status()

    def _map_name(self) -> str:
        if self._settings.map_file:
            return self._settings.map_file
        self.get_logger().warning(
            'NO MAP GIVEN: using the demo floor, whose poses are meaningless on your floor; set map_file'
        )
        return 'demo floor (no map_file given)'

    def _advertise(self) -> None:
        self._pose = self.create_publisher(PoseStamped, '~/pose', pose_profile())
        self._pose_with_covariance = self.create_publisher(
            PoseWithCovarianceStamped, '~/pose_with_covariance', pose_profile()
        )
        self._dots = self.create_publisher(MarkerArray, '~/dots', pose_profile())
        self._debug_image = self.create_publisher(Image, '~/debug_image', pose_profile())
        create_trigger_service(self, self._guard, '~/relocalize', self._relocalize)

    def _subscribe(self) -> None:
        topics, transport = ('image_raw', 'camera_info'), self._settings.image_transport
        ImageInput(self, self._guard, topics, transport, camera_from_camera_info, self._on_image)
        self._inputs.add_images(*topics)
        self.subscribe(Odometry, 'odom', self._on_odometry, odometry_profile(), Need.OPTIONAL)
        self.subscribe(PoseWithCovarianceStamped, 'initialpose', self._on_initial_pose, pose_profile(), Need.REQUEST)

    def _on_image(self, header: Header, pixels: Pixels, camera: PinholeCamera) -> None:
        stamp = self._stamps.check(header, 'image_raw')
        mount = self._frames.mount(header, self._settings.mount)
        if mount != self._mount:
            self._use_mount(self._settings, mount)
        started = perf_counter()
        result = self._tracker.track(stamp, pixels, camera)
        self._report.add(result, perf_counter() - started)
        self._log_change(result)
        self._publish(Header(stamp=header.stamp, frame_id=self._pose_frame(result)), result, camera)
        if self._debug_image.get_subscription_count() > 0:
            self._debug_image.publish(image_from_array(debug_picture(pixels, result), header))

    def _pose_frame(self, result: Fix | NoFix) -> str:
        """Return the frame of a pose: each level of a map has its own, such as ``map/ground``."""
        level = result.level if isinstance(result, Fix) else ''
        return f'{self._settings.map_frame}/{level}' if level else self._settings.map_frame

    def _log_change(self, result: Fix | NoFix) -> None:
        """Log one line when the pose is found or lost; details are in the diagnostics."""
        has_fix = isinstance(result, Fix)
        if has_fix == self._had_fix:
            return
        self._had_fix = has_fix
        if isinstance(result, Fix):
            pose = result.T_map_base
            where = f' on {result.level}' if result.level else ''
            self.get_logger().info(
                f'pose found{where}: x {pose.x:.4f} m, y {pose.y:.4f} m, yaw {pose.yaw:.4f} rad, '
                f'{int(result.matched.sum())} of {len(result.dots)} dots match',
                throttle_duration_sec=_LOG_INTERVAL,
            )
        else:
            self.get_logger().info(
                f'no pose: {result.reason.value} ({result.detail})', throttle_duration_sec=_LOG_INTERVAL
            )

    def _publish(self, header: Header, result: Fix | NoFix, camera: PinholeCamera) -> None:
        if isinstance(result, Fix):
            self._pose.publish(pose_stamped(result.T_map_base, header))
            self._pose_with_covariance.publish(
                pose_with_covariance_stamped(result.T_map_base, result.covariance, header)
            )
        if self._dots.get_subscription_count() > 0:
            markers = delete_markers(header)
            if isinstance(result, Fix):
                markers = dot_markers(result, camera, self._mount, header)
            self._dots.publish(markers)

    def _on_odometry(self, message: Odometry) -> None:
        T_odom_base = base_odometry(message, 'odom', self._settings.base_frame)
        stamp = self._stamps.check(message.header, 'odom')
        self._tracker.add_odometry(stamp, T_odom_base)

    def _on_initial_pose(self, message: PoseWithCovarianceStamped) -> None:
        map_frame, frame = self._settings.map_frame, message.header.frame_id or self._settings.map_frame
        root, _, level = frame.partition(f'{map_frame}/')
        if frame != map_frame and (root or not level):
            refusal = f'initialpose is in {frame!r}, it must be in {map_frame!r} or one of its levels'
            area = self._frames.pose_with_covariance_to(
                map_frame, message, 'initialpose', refusal, is_latest_valid=True
            )
            self._tracker.set_area(*area)
        else:
            self._tracker.set_area(*planar_pose_with_covariance(message.pose, 'initialpose'), level)

    def _relocalize(self) -> str:
        self._tracker.relocalize()
        return 'prior dropped; the next image is searched in the whole map'

    def _reset(self) -> None:
        self.get_logger().warning('clock jumped back; pose and odometry were reset')
        self._tracker = self._create_tracker(self._localizer, self._settings.tracker)


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node('floor_localizer', FloorLocalizerNode)


if __name__ == '__main__':
    sys.exit(main())
