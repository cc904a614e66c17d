"""Subscriptions to point clouds, depth images or three cameras; each passes on points in the optical frame."""

from collections.abc import Callable
from functools import partial
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from std_msgs.msg import Header

from reward_planner.core.depth.trinocular_depth import TrinocularRig, points_from_depth_image
from reward_planner.core.navigator import SensorFrame
from reward_planner.core.settings import VoxelSettings
from reward_planner.core.voxels.rolling_voxel_grid import equivalent_focal_length
from reward_planner.node_settings import NodeSettings
from shirube_core.geometry import SE3, CameraMount, PinholeCamera
from shirube_ros.callback_guard import CallbackGuard
from shirube_ros.camera.image import depth_from_image
from shirube_ros.camera.info import RigCamera, rectified_camera, rig_camera
from shirube_ros.camera.input import ImageInput
from shirube_ros.errors import CameraInfoError, FrameError
from shirube_ros.frames import Frames
from shirube_ros.message_conversion import points_from_cloud
from shirube_ros.quality_of_service import overridable, sensor_profile
from shirube_ros.stamps import StampSynchronizer

FrameCallback = Callable[[Header, SensorFrame], None]
"""Called with the header of a message and its points in the optical frame of the camera."""

_POINTS, _IMAGE, _INFO = 'points', 'depth/image', 'depth/camera_info'
_OPTICAL = '_optical_frame'
_CAMERAS = ('left', 'right', 'top')
_SYNC_TOLERANCE = 0.005  # largest difference of stamps of one trigger [s]


class PointsInput:
    """Subscribes to ``points`` (PointCloud2) in the camera's optical frame, in ``base_frame`` or in any frame of TF.

    Attributes:
        mount: pose of the camera on the robot.
    """

    def __init__(
        self, node: Node, guard: CallbackGuard, settings: NodeSettings, frames: Frames, on_frame: FrameCallback
    ) -> None:
        """Subscribe; `guard` counts the messages and catches their errors."""
        self._on_frame, self._frames = on_frame, frames
        self.mount = settings.mount  # origin of rays also for points in the base frame
        # An empty camera frame takes the first one received.
        self._base_frame, self._camera_frame = settings.base_frame, settings.camera_frame
        _subscribe(node, guard, PointCloud2, _POINTS, self._take)

    def _take(self, message: PointCloud2) -> None:
        frame, mount = message.header.frame_id, self.mount
        is_camera = frame.endswith(_OPTICAL) and not self._camera_frame
        is_camera |= bool(frame) and frame == self._camera_frame
        if is_camera:
            mount = self._frames.mount(message.header, self.mount)
        elif frame != self._base_frame:
            # The rays start at the sensor; its axes may be any, so those of the camera are used.
            T_base_cloud = self._cloud_pose(message.header)
            x, y, z = T_base_cloud.position.tolist()
            mount = CameraMount((x, y, z), mount.rpy)
        points = points_from_cloud(message, _POINTS)
        if is_camera:
            self._camera_frame = frame  # the mount belongs to one camera
        else:
            if frame != self._base_frame:
                points = T_base_cloud.transform(points).astype(np.float32)
            shifted = points - np.asarray(mount.xyz, dtype=np.float32)
            points = shifted @ mount.rotation.astype(np.float32)
        self._on_frame(message.header, SensorFrame(points, equivalent_focal_length(points), mount))

    def _cloud_pose(self, header: Header) -> SE3:
        """Return the pose of a cloud of another frame than the camera's; raise a FrameError if TF has none."""
        frame = header.frame_id
        if self._camera_frame:
            remedy = (
                f'in the frame {frame!r}, the camera with this mount is {self._camera_frame!r}; '
                f'publish one camera only, or transform the others to {self._base_frame!r}'
            )
        else:
            remedy = (
                f"in the unknown frame {frame!r}; publish it in {self._base_frame!r} or in the camera's frame, "
                f'whose name ends with "{_OPTICAL}"'
            )
        if not frame:
            raise FrameError(f'{_POINTS} is {remedy}')
        return self._frames.to(self._base_frame, header, f'{_POINTS} is {remedy}')


class DepthInput:
    """Subscribes to ``depth/image`` (Image, 32FC1 or 16UC1) and ``depth/camera_info`` (CameraInfo)."""

    def __init__(self, node: Node, guard: CallbackGuard, voxels: VoxelSettings, on_frame: FrameCallback) -> None:
        """Subscribe; `guard` counts the messages and catches their errors."""
        self._camera: PinholeCamera | None = None
        # The voxel map counts points at range_min, but none that rounding brings nearer.
        self._on_frame, self._nearest = on_frame, 1.001 * voxels.range_min
        _subscribe(node, guard, CameraInfo, _INFO, self._take_info)
        _subscribe(node, guard, Image, _IMAGE, self._take_image)

    def _take_info(self, message: CameraInfo) -> None:
        self._camera = None  # after an invalid calibration the old one must not be used
        self._camera = rectified_camera(message, _INFO)

    def _take_image(self, message: Image) -> None:
        depth = depth_from_image(message, _IMAGE)
        if self._camera is None:
            raise CameraInfoError(f'{_IMAGE} was received without a valid {_INFO}; publish the calibration')
        points = points_from_depth_image(depth, self._camera, nearest=self._nearest)
        self._on_frame(message.header, SensorFrame(points, self._camera.fx))


class TrinocularInput:
    """Subscribes to ``image_rect`` and ``camera_info`` of ``left/``, ``right/`` and ``top/`` and synchronizes them.

    Attributes:
        groups: images that wait for others of the same stamp, and the number of dropped ones.
    """

    def __init__(self, node: Node, guard: CallbackGuard, settings: NodeSettings, on_frame: FrameCallback) -> None:
        """Subscribe; `guard` counts the messages and catches their errors."""
        self._settings, self._on_frame = settings.depth, on_frame
        self._logger = node.get_logger()
        self.groups = StampSynchronizer[tuple[Header, NDArray[np.uint8]]](_CAMERAS, _SYNC_TOLERANCE)
        self._cameras: dict[str, RigCamera] = {}
        self._projections: NDArray[np.float64] | None = None
        self._rig: TrinocularRig | None = None
        for name in _CAMERAS:
            topics, take = (f'{name}/image_rect', f'{name}/camera_info'), partial(self._take, name)
            ImageInput(node, guard, topics, settings.image_transport, rig_camera, take)

    def _take(self, name: str, header: Header, pixels: NDArray[np.uint8], camera: RigCamera) -> None:
        grey = pixels if pixels.ndim == 2 else np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY))
        stamp = header.stamp.sec + 1e-9 * header.stamp.nanosec
        self._cameras[name] = camera
        group = self.groups.put(name, stamp, (header, grey))
        if group is None:
            return
        rig = self._rig_of(np.array([self._cameras[each].projection for each in _CAMERAS]))
        (first, left_image), (_, right_image), (_, top_image) = group
        was_mirrored = rig.is_mirrored
        depth = rig.compute(left_image, right_image, top_image).depth
        if rig.is_mirrored and not was_mirrored:
            self._logger.warning(
                'P[1, 3] of top/camera_info has the wrong sign: the images show the camera on the other side of the '
                'left one; the images are used'
            )
        left = self._cameras['left']
        points = points_from_depth_image(depth, left.camera, float(left.projection[0, 1]))
        self._on_frame(first, SensorFrame(points, left.camera.fx))

    def _rig_of(self, projections: NDArray[np.float64]) -> TrinocularRig:
        """Return the rig for projection matrices P, shape (3, 3, 4); a new one if the calibration changed."""
        is_same = self._projections is not None and np.array_equal(self._projections, projections)
        if self._rig is None or not is_same:
            self._rig = TrinocularRig(projections, self._settings)
            self._projections = projections
        return self._rig


def _subscribe(node: Node, guard: CallbackGuard, kind: type, topic: str, take: Callable[[Any], None]) -> None:
    guarded = guard.guard(topic, take)
    node.create_subscription(kind, topic, guarded, sensor_profile(), qos_overriding_options=overridable())
