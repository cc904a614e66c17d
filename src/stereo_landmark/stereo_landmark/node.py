"""ROS node: stereo images in, displacement from a taught place and robot pose out."""

import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, TransformStamped
from numpy.typing import NDArray
from sensor_msgs.msg import Image, Imu
from std_msgs.msg import Header
from visualization_msgs.msg import MarkerArray

from shirube_core.settings import SettingsError
from shirube_ros.callback_guard import create_trigger_service
from shirube_ros.camera.image import image_from_array, to_grey
from shirube_ros.camera.input import ImageInput
from shirube_ros.diagnostics import Status
from shirube_ros.frames import Frames
from shirube_ros.input_watch import Need
from shirube_ros.managed_node import ManagedNode
from shirube_ros.message_conversion import pose_stamped, pose_with_covariance_stamped, tilt_from_imu
from shirube_ros.node import drain_subscription, run_node
from shirube_ros.quality_of_service import odometry_profile, pose_profile
from shirube_ros.stamps import StampValidator
from stereo_landmark.core.landmark_localizer import LandmarkFix, LandmarkLocalizer, NoLandmarkFix
from stereo_landmark.core.pair.camera_pair import CameraCalibration, Side
from stereo_landmark.core.pair.pair_stream import LocatedPair, PairStream
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import BOTH, SHAPES, LandmarkSettings
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.files.camera_files import calibration_from_camera_info
from stereo_landmark.files.place_file import load_images, load_places, place_path
from stereo_landmark.node_output import LocalizerReport, debug_picture, displacement_message, target_markers
from stereo_landmark.node_settings import NodeSettings

_LOG_INTERVAL = 1.0
"""Minimum time between log lines about place changes [s]."""
_NANOSECONDS = 1_000_000_000

CreateStream = Callable[..., PairStream]


class StereoLandmarkNode(ManagedNode):
    """Publishes the robot's pose relative to its taught places from stereo images of their targets.

    =========================  ============================  =============================================
    subscribed                 type                          use
    =========================  ============================  =============================================
    ``left/image_rect``        Image or CompressedImage      left image; raw with ``rectify``
    ``left/camera_info``       CameraInfo                    calibration of the left camera
    ``right/image_rect``       Image or CompressedImage      right image; raw with ``rectify``
    ``right/camera_info``      CameraInfo                    calibration of the right camera, baseline
    ``imu``                    Imu                           optional: tilt of ``base_frame``
    =========================  ============================  =============================================

    =========================  ============================  =============================================
    published                  type                          when
    =========================  ============================  =============================================
    ``~/displacement``         TransformStamped              each fix: robot pose in the place frame
    ``~/pose``                 PoseStamped                   each fix at a place with a pose in the map
    ``~/pose_with_covariance`` PoseWithCovarianceStamped     each fix at a place with a pose in the map
    ``~/targets``              MarkerArray                   while it has subscribers
    ``~/debug_image``          Image                         while it has subscribers
    ``/diagnostics``           DiagnosticArray               1 Hz
    =========================  ============================  =============================================

    The service ``~/relocalize`` (std_srvs/Trigger) drops the prior: all places are searched again.
    """

    SETTINGS = (NodeSettings, LandmarkSettings)
    ERRORS = (StereoLandmarkError,)

    def __init__(self, create_stream: CreateStream = PairStream, **options: Any) -> None:
        """Declare the parameters, and start.

        Args:
            create_stream: factory of the localizer, called at the start and after a jump back in time.
            options: keyword arguments of ``rclpy.node.Node``.

        Raises:
            SettingsError: a parameter is invalid.
            StereoLandmarkError: a place file is invalid.
        """
        super().__init__('stereo_landmark', **options)
        self._create_stream = create_stream
        self.start()

    def check_settings(self) -> None:
        """Raise a SettingsError if there is no folder of places."""
        if not self.settings(NodeSettings).places_dir:
            raise SettingsError('places_dir is not set; give the folder of the taught places')

    def configure(self) -> None:
        """Load and validate the places, then subscribe."""
        self._settings = self.settings(NodeSettings)
        folder = Path(self._settings.places_dir)
        self._places = load_places(folder)
        _check_frames(self._places, self._settings)
        for line in validate_places(folder, self._places, self.settings(LandmarkSettings)):
            self.get_logger().warning(line)
        self._mount = self._settings.mount
        self._stream = self._new_stream()
        self._frames = Frames(self, self._settings.base_frame)
        self._last_place_name: str | None = ''
        self._left_frame = ''
        self._report = LocalizerReport(self._settings.places_dir)
        self._stamps = StampValidator(self._reset_stream)
        self._advertise()
        self._subscribe()

    def apply_settings(self) -> None:
        """Use changed settings from the next pair on."""
        self._stream.apply_settings(self.settings(LandmarkSettings))

    def status(self) -> Status:
        """Return the latest result."""
        return self._report.status()

    def _new_stream(self) -> PairStream:
        method = self.settings(LandmarkSettings)
        return self._create_stream(self._places, self._mount, self._settings, method)

    def _advertise(self) -> None:
        self._displacement = self.create_publisher(TransformStamped, '~/displacement', pose_profile())
        self._pose = self.create_publisher(PoseStamped, '~/pose', pose_profile())
        self._pose_with_covariance = self.create_publisher(
            PoseWithCovarianceStamped, '~/pose_with_covariance', pose_profile()
        )
        self._targets = self.create_publisher(MarkerArray, '~/targets', pose_profile())
        self._debug_image = self.create_publisher(Image, '~/debug_image', pose_profile())
        create_trigger_service(self, self._guard, '~/relocalize', self._relocalize)

    def _subscribe(self) -> None:
        for side in Side:
            name = side.name.lower()
            topics = f'{name}/image_rect', f'{name}/camera_info'
            self._inputs.add_images(*topics)
            ImageInput(
                self,
                self._guard,
                topics,
                self._settings.image_transport,
                calibration_from_camera_info,
                partial(self._take_image, side),
            )
        self._imu = self.subscribe(Imu, 'imu', self._take_imu, odometry_profile(), Need.OPTIONAL)

    def _take_image(
        self, side: Side, header: Header, pixels: NDArray[np.uint8], calibration: CameraCalibration
    ) -> None:
        self._stamps.check(header, f'{side.name.lower()}/image_rect')
        stamp_ns = header.stamp.sec * _NANOSECONDS + header.stamp.nanosec
        if side is Side.LEFT:
            self._left_frame = header.frame_id
            mount = self._frames.mount(header, self._settings.mount)
            if mount != self._mount:
                self._mount = mount
                self._stream = self._new_stream()
        # The IMU reading of this stamp may still be in the queue.
        drain_subscription(self._imu)
        started = perf_counter()
        located = self._stream.add_image(side, stamp_ns, to_grey(pixels), calibration)
        if located is None:
            return
        self._report.add(located, perf_counter() - started)
        self._log_place_change(located.result)
        self._publish(located)

    def _take_imu(self, message: Imu) -> None:
        roll, pitch = tilt_from_imu(message, 'imu')
        stamp = self._stamps.check(message.header, 'imu')
        # After the stamp check, which creates a new stream after a jump back in time.
        self._stream.add_tilt(stamp, roll, pitch)

    def _publish(self, located: LocatedPair) -> None:
        """Publish the result of a pair with the stamp of its left image."""
        result, settings = located.result, self._settings
        seconds, rest = divmod(located.stamp_ns, _NANOSECONDS)
        header = Header(frame_id=settings.base_frame)
        header.stamp.sec, header.stamp.nanosec = seconds, rest
        if isinstance(result, LandmarkFix):
            self._displacement.publish(displacement_message(result, header.stamp, settings.base_frame))
            if result.T_map_base is not None:
                in_map = Header(stamp=header.stamp, frame_id=settings.map_frame)
                self._pose.publish(pose_stamped(result.T_map_base, in_map))
                self._pose_with_covariance.publish(
                    pose_with_covariance_stamped(result.T_map_base, result.map_covariance, in_map)
                )
        if self._targets.get_subscription_count() > 0:
            self._targets.publish(target_markers(located, header))
        if self._debug_image.get_subscription_count() > 0:
            picture_header = Header(stamp=header.stamp, frame_id=self._left_frame)
            self._debug_image.publish(image_from_array(debug_picture(located), picture_header))

    def _log_place_change(self, result: LandmarkFix | NoLandmarkFix) -> None:
        """Log a line when the robot arrives at a place or leaves it; diagnostics report the rest."""
        place_name = result.place.name if isinstance(result, LandmarkFix) else None
        if place_name == self._last_place_name:
            return
        if isinstance(result, LandmarkFix):
            pose = result.displacement.T_place_base
            line = f'at {place_name}: x {pose.x:.3f} m, y {pose.y:.3f} m, yaw {pose.yaw:.3f} rad'
        else:
            line = f'at no place: {result.reason} ({result.detail})'
        if self.get_logger().info(line, throttle_duration_sec=_LOG_INTERVAL):
            self._last_place_name = place_name

    def _relocalize(self) -> str:
        self._stream.drop_prior()
        return 'last place dropped; searching all places'

    def _reset_stream(self) -> None:
        self.get_logger().warning('clock jumped back; queued images and the last place were reset')
        self._stream = self._new_stream()


def validate_places(folder: Path, places: Iterable[TaughtPlace], settings: LandmarkSettings) -> list[str]:
    """Return a warning for each place that is not found in its own taught images.

    Raises:
        StereoLandmarkError: an image is missing, corrupted or has the wrong size.
    """
    lines = []
    # Features would find a place whose targets are of no use.
    settings = replace(settings, method=SHAPES) if settings.method == BOTH else settings
    for place in places:
        # Loading again reports why the images of a place are missing.
        images = place.images or load_images(place_path(folder, place.name))
        result = LandmarkLocalizer([place], settings).locate(images.left, images.right, images.tilt)
        if isinstance(result, NoLandmarkFix):
            lines.append(
                f'place {place.name} is not found in the images it was taught from: {result.reason} ({result.detail}); '
                'teach it with other targets, or correct the parameters'
            )
    return lines


def _check_frames(places: Sequence[TaughtPlace], settings: NodeSettings) -> None:
    """Check that no place, which is a frame of ``~/displacement``, has the name of another frame."""
    for field, frame in (('map_frame', settings.map_frame), ('base_frame', settings.base_frame)):
        if frame in [place.name for place in places]:
            raise StereoLandmarkError(
                f'place {frame} has the same name as {field}; teach it under another name, or set {field}'
            )


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node('stereo_landmark', StereoLandmarkNode)


if __name__ == '__main__':
    sys.exit(main())
