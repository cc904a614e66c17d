"""Subscriptions of the collision monitor to point clouds, depth images and laser scans."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field, make_dataclass
from functools import partial
from keyword import iskeyword
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rcl_interfaces.msg import ParameterDescriptor
from sensor_msgs.msg import CameraInfo, Image, LaserScan, PointCloud2
from std_msgs.msg import Header

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.safety.collision_monitor import CollisionMonitor
from reward_planner.core.safety.range_frame import depth_rays, range_frame
from reward_planner.core.safety.safety_settings import SourceSettings, sensor_rpy
from shirube_core.geometry import PinholeCamera, matrix_from_rpy
from shirube_core.settings import SettingsError, setting
from shirube_ros.camera.image import depth_from_image
from shirube_ros.camera.info import rectified_camera
from shirube_ros.errors import CameraInfoError, MessageError
from shirube_ros.input_watch import Need
from shirube_ros.managed_node import ManagedNode
from shirube_ros.message_conversion import points_from_cloud, rays_from_scan
from shirube_ros.quality_of_service import sensor_profile

DEFAULT_SOURCES = ('front',)
_PARAMETER = 'sources'


@dataclass(frozen=True)
class MonitorNodeSettings:
    """Frame and type of the velocities."""

    base_frame: str = setting('base_link', 'frame of the robot')
    stamped: bool = setting(
        True, 'whether cmd_vel_in and cmd_vel are TwistStamped rather than Twist, as in motor_bridge'
    )


def declare_sources(node: ManagedNode) -> type:
    """Declare ``sources`` and the parameters of each one; return the class of their settings, one group a source.

    Raises:
        SettingsError: no names, an invalid or duplicate name, or an invalid value.
    """
    descriptor = ParameterDescriptor(
        description='names of the range sensors; each has the parameters <name>.type and so on', dynamic_typing=True
    )
    value = node.declare_parameter(_PARAMETER, list(DEFAULT_SOURCES), descriptor).value
    names = [str(name) for name in value] if isinstance(value, (list, tuple)) else []
    if not names or len(set(names)) < len(names):
        raise SettingsError(f'setting {_PARAMETER} is {value!r}; give a list of different names, such as [front]')
    for name in names:
        if not re.fullmatch(r'[a-z][a-z0-9_]*', name) or iskeyword(name) or node.has_parameter(name):
            raise SettingsError(
                f'setting {_PARAMETER} holds {name!r}; a name has lower-case letters, digits and underscores, '
                'and is no keyword and no parameter'
            )
    groups = make_dataclass(
        'SourceGroups', [(name, SourceSettings, field(default_factory=SourceSettings)) for name in names], frozen=True
    )
    node.declare(groups)
    return groups


_TOPICS = {'points': 'points', 'depth': 'depth/image', 'scan': 'scan'}
_KINDS = {'points': PointCloud2, 'depth': Image, 'scan': LaserScan}
Rays = tuple[NDArray[np.float32], NDArray[np.bool_]]


class MonitorInput:
    """One source: each message becomes rays in the base frame; an invalid one stops the robot until a valid one."""

    def __init__(
        self,
        node: ManagedNode,
        monitor: CollisionMonitor,
        source: tuple[str, SourceSettings, str],
        on_frame: Callable[[], None],
    ) -> None:
        """Subscribe to a source, given as name, settings and the robot's frame; ``on_frame`` is called after each."""
        self._node, self._monitor, self._on_frame = node, monitor, on_frame
        self._name, self._settings, self._base_frame = source
        self._frame = self._settings.frame
        self._rotation = matrix_from_rpy(sensor_rpy(self._settings))
        self._camera: PinholeCamera | None = None
        kind = self._settings.type
        self._topic = self._settings.topic or _TOPICS[kind]
        self._subscribe(_KINDS[kind], self._topic, self._take)
        if kind == 'depth':
            self._info = f'{self._topic.rpartition("/")[0]}/camera_info'.removeprefix('/' * (self._topic[0] != '/'))
            self._subscribe(CameraInfo, self._info, self._take_info)

    def _subscribe(self, kind: type, topic: str, take: Callable[[Any], None]) -> None:
        callback = partial(self._stop_on_error, take)
        self._node.subscribe(kind, topic, callback, sensor_profile(), Need.EXPECTED)

    def _stop_on_error(self, take: Callable[[Any], None], message: Any) -> None:
        try:
            take(message)
        except (MessageError, RewardPlannerError) as error:
            self._monitor.invalidate(self._name, str(error).removeprefix(f'{self._name}: '))
            raise
        except Exception:
            self._monitor.invalidate(self._name, 'internal error, see the log')
            raise
        finally:
            self._on_frame()

    def _take_info(self, message: CameraInfo) -> None:
        self._camera = None
        self._camera = rectified_camera(message, self._info)

    def _take(self, message: Any) -> None:
        rotation, origin = self._mount_of(message.header)
        ends, is_hit = self._rays(message)
        stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
        now = 1e-9 * self._node.get_clock().now().nanoseconds
        self._monitor.add_frame(self._name, stamp, now, range_frame(ends, is_hit, rotation, origin))

    def _mount_of(self, header: Header) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return R_base_sensor and the position of the sensor; only one frame, or the robot's own, is accepted."""
        frame, origin = header.frame_id, np.array(self._settings.xyz)
        if frame == self._base_frame and self._settings.frame != frame:
            return np.eye(3), origin  # already in the base frame, seen from the sensor
        if not frame or (self._frame and frame != self._frame):
            raise RewardPlannerError(
                f'{self._name}: {self._topic} is in another frame than {self._frame!r}; set {self._name}.frame'
            )
        self._frame = frame
        return self._rotation, origin

    def _rays(self, message: Any) -> Rays:
        match self._settings.type:
            case 'scan':
                return rays_from_scan(message, self._topic)
            case 'depth':
                depth = depth_from_image(message, self._topic)
                if self._camera is None:
                    raise CameraInfoError(f'{self._topic} was received without a valid {self._info}; publish it')
                return depth_rays(depth, self._camera, (self._settings.range_min, self._settings.range_max))
            case _:
                points = points_from_cloud(message, self._topic)
                if self._frame != message.header.frame_id:
                    points = points - np.asarray(self._settings.xyz, dtype=np.float32)
                return points, np.ones(len(points), dtype=np.bool_)
