"""Where sensors and poses are: the parameters of a camera's mount, and TF where tf2_ros is installed."""

import time
from importlib import import_module
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time as Stamp
from geometry_msgs.msg import Point, Pose, Quaternion, Transform, TransformStamped, Vector3
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.time import Time
from std_msgs.msg import Header

from shirube_core.geometry import SE2, SE3, CameraMount, rotation_matrix
from shirube_ros.errors import FrameError
from shirube_ros.message_conversion import planar_pose_with_covariance

_TF = QoSProfile(depth=100)
_STATIC = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class TransformPublisher:
    """Publishes transforms as tf2 does; only the messages of tf2 are needed, not its library."""

    def __init__(self, node: Node, *, is_static: bool = False) -> None:
        """Create the publisher; without tf2_msgs nothing is published, and for /tf the console says so."""
        self._is_static = is_static
        self._latched: dict[str, TransformStamped] = {}
        self._publisher: Any = None
        topic = '/tf_static' if is_static else '/tf'
        try:
            self._kind = import_module('tf2_msgs.msg').TFMessage
        except ImportError:
            if not is_static:
                node.get_logger().info('tf2_msgs is not installed; nothing is published on /tf')
            return
        self._publisher = node.create_publisher(self._kind, topic, _STATIC if is_static else _TF)

    def publish(self, stamp: Stamp, parent: str, child: str, pose: Pose) -> None:
        """Publish the pose of a child frame in its parent; static ones are kept for nodes that start later."""
        if self._publisher is None:
            return
        place = pose.position
        message = TransformStamped(
            header=Header(stamp=stamp, frame_id=parent),
            child_frame_id=child,
            transform=Transform(translation=Vector3(x=place.x, y=place.y, z=place.z), rotation=pose.orientation),
        )
        if self._is_static:
            self._latched[child] = message
        transforms = list(self._latched.values()) if self._is_static else [message]
        self._publisher.publish(self._kind(transforms=transforms))


_MOUNT_PARAMETERS = ('camera_xyz', 'camera_rpy')
_STARTUP = 3.0  # time after the first image in which TF may still be incomplete [s]
_SAME = 1e-6  # [m] and of a rotation matrix


class Frames:
    """Looks up transforms for a node.

    The mount of a camera is that of the parameters if one of them is set, else that of TF, else the default. Without
    tf2_ros, what is in another frame is rejected.
    """

    def __init__(self, node: Node, base_frame: str) -> None:
        """Listen to TF, where tf2_ros is installed; ``base_frame`` is the frame of the robot."""
        self._node, self._base_frame = node, base_frame
        self._is_set = any(name in node._parameter_overrides for name in _MOUNT_PARAMETERS)  # noqa: SLF001
        self._default: CameraMount | None = None
        self._published: dict[str, CameraMount] = {}
        self._static: TransformPublisher | None = None
        self._first_image = float('nan')
        self._is_warned = False
        try:
            self._tf2: Any = import_module('tf2_ros')
        except ImportError:
            node.get_logger().info(
                'tf2_ros is not installed; input must be in the frames of the parameters, and mounts are not published'
            )
            self._tf2 = None
            return
        self._buffer = self._tf2.Buffer()
        self._listener = self._tf2.TransformListener(self._buffer, node)

    def mount(self, header: Header, parameters: CameraMount) -> CameraMount:
        """Return the mount of the camera of a message; ``parameters`` is that of the parameters.

        Raises:
            FrameError: TF has the camera but not at this stamp, or may get it soon.
        """
        self._default = self._default or parameters
        if self._is_set or parameters != self._default:
            self._publish(header, parameters)
            return parameters
        frame = header.frame_id
        found = self._look_up(self._base_frame, frame, header.stamp)
        if found is not None:
            return _mount_of(found)
        if self._tf2 is not None and frame:
            now = time.monotonic()
            self._first_image = now if np.isnan(self._first_image) else self._first_image
            is_known = self._look_up(self._base_frame, frame, Stamp()) is not None
            if is_known or (now - self._first_image < _STARTUP and not self._is_warned):
                raise FrameError(self._missing(self._base_frame, frame))
        self._warn_of_default(frame)
        return parameters

    def to(self, target: str, header: Header, refusal: str, *, is_latest_valid: bool = False) -> SE3:
        """Return ``T_target_source`` at the stamp of a message.

        Args:
            target: frame that is needed.
            header: frame and stamp of the message; an empty frame is the target.
            refusal: error message without a transform, with the remedy.
            is_latest_valid: whether the latest transform serves if there is none at the stamp, as for an operator's
                input.

        Raises:
            FrameError: there is no transform.
        """
        source = header.frame_id
        if source in ('', target):
            return SE3(np.eye(3), np.zeros(3))
        found = self._look_up(target, source, header.stamp)
        if found is None and is_latest_valid:
            found = self._look_up(target, source, Stamp())
        if found is None:
            raise FrameError(refusal if self._tf2 is None else f'{refusal} ({self._missing(target, source)})')
        return found

    def pose_to(self, target: str, header: Header, pose: SE2, refusal: str, *, is_latest_valid: bool = False) -> SE2:
        """Return a pose of a message in the frame that is needed; arguments and errors as in `to`."""
        if header.frame_id in ('', target):
            return pose
        return _planar(self.to(target, header, refusal, is_latest_valid=is_latest_valid)) @ pose

    def pose_with_covariance_to(
        self, target: str, message: Any, topic: str, refusal: str, *, is_latest_valid: bool = False
    ) -> tuple[SE2, NDArray[np.float64]]:
        """Return a pose and its covariance of (x, y, yaw), shape (3, 3), in the frame that is needed.

        Raises:
            FrameError: there is no transform.
            PoseError: the PoseWithCovarianceStamped is invalid.
        """
        pose, covariance = planar_pose_with_covariance(message.pose, topic)
        if message.header.frame_id in ('', target):
            return pose, covariance
        T_target_source = _planar(self.to(target, message.header, refusal, is_latest_valid=is_latest_valid))
        turn = np.eye(3)
        turn[:2, :2] = rotation_matrix(T_target_source.yaw)
        return T_target_source @ pose, np.asarray(turn @ covariance @ turn.T)

    def _look_up(self, target: str, source: str, stamp: Stamp) -> SE3 | None:
        """Return ``T_target_source`` of TF, None if it has none; the stamp 0 is that of the latest."""
        if self._tf2 is None or not source:
            return None
        try:
            found = self._buffer.lookup_transform(target, source, Time.from_msg(stamp)).transform
        except self._tf2.TransformException:
            return None
        quaternion, place = found.rotation, found.translation
        rotation = _rotations().from_quat([quaternion.x, quaternion.y, quaternion.z, quaternion.w])
        return SE3(rotation.as_matrix(), np.array([place.x, place.y, place.z]))

    def _missing(self, target: str, source: str) -> str:
        return f'TF has no transform from {source!r} to {target!r} at the stamp; publish it'

    def _publish(self, header: Header, mount: CameraMount) -> None:
        """Publish the mount of the parameters, unless TF has the same from elsewhere."""
        frame = header.frame_id
        if frame in ('', self._base_frame) or self._published.get(frame) == mount:
            return
        known = self._look_up(self._base_frame, frame, Stamp())
        if known is None or not _is_same(known, mount) or frame in self._published:
            # A copy: scipy before 1.12 rejects read-only arrays.
            x, y, z, w = _rotations().from_matrix(mount.rotation.copy()).as_quat().tolist()
            position = Point(x=mount.xyz[0], y=mount.xyz[1], z=mount.xyz[2])
            pose = Pose(position=position, orientation=Quaternion(x=x, y=y, z=z, w=w))
            self._static = self._static or TransformPublisher(self._node, is_static=True)
            self._static.publish(self._node.get_clock().now().to_msg(), self._base_frame, frame, pose)
        self._published[frame] = mount

    def _warn_of_default(self, frame: str) -> None:
        if not self._is_warned:
            self._is_warned = True
            self._node.get_logger().warning(
                f'neither camera_xyz and camera_rpy nor TF give the pose of {frame or "the camera"!r} in '
                f'{self._base_frame!r}; the default is used'
            )


def _rotations() -> Any:
    from scipy.spatial.transform import Rotation  # noqa: PLC0415 takes 0.2 s, and not every node rotates

    return Rotation


def _mount_of(T_base_camera: SE3) -> CameraMount:
    x, y, z = T_base_camera.position.tolist()
    roll, pitch, yaw = _rotations().from_matrix(T_base_camera.rotation.copy()).as_euler('xyz').tolist()
    return CameraMount((x, y, z), (roll, pitch, yaw))


def _is_same(T_base_camera: SE3, mount: CameraMount) -> bool:
    change = T_base_camera.inverse() @ SE3(mount.rotation, np.array(mount.xyz))
    return bool(np.abs(change.rotation - np.eye(3)).max() < _SAME and np.abs(change.position).max() < _SAME)


def _planar(T: SE3) -> SE2:
    return SE2(float(T.position[0]), float(T.position[1]), float(np.arctan2(T.rotation[1, 0], T.rotation[0, 0])))
