"""Parameters and topics of the six nodes on the mission."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import yaml

from scene_simulator.mission_floor import BELLY_MOUNT
from scene_simulator.mission_lamps import CEILING_CAMERA, CEILING_MOUNT, LAMP_RATE
from scene_simulator.mission_layout import ROBOT_HEIGHT, ROBOT_RADIUS
from scene_simulator.mission_sensors import DEPTH_MOUNT, STEREO_RIG
from shirube_bringup.building_files import BuildingFiles
from shirube_bringup.lamp_programs import CRUISE_SPEED
from shirube_core.geometry import CameraMount

Value = str | bool | int | float | list[float] | list[str]

COMMAND_RADIUS = 2.0
"""Radius around a lamp in which its commands are obeyed [m]."""

GOAL_TOLERANCE = 0.01
"""Goal tolerance of the planner [m]."""


@dataclass(frozen=True)
class NodeSetup:
    """Command line of a node.

    Attributes:
        package: package name, which is also the node name.
        parameters: parameters that differ from the default.
        topics: remapped topics.
        images: resolved image topics that are subscribed to reliably.
    """

    package: str
    parameters: Mapping[str, Value]
    topics: Mapping[str, str]
    images: tuple[str, ...] = ()

    def arguments(self, folder: Path) -> list[str]:
        """Write the parameters to a file in a folder and return the node's command line."""
        values: dict[str, Value] = {'use_sim_time': True, **self.parameters}
        for topic in self.images:
            values[f'qos_overrides.{topic}.subscription.reliability'] = 'reliable'
        path = folder / f'{self.package}.yaml'
        path.write_text(yaml.safe_dump({self.package: {'ros__parameters': values}}))
        remapped = [
            argument for name, topic in self.topics.items() for argument in ('-r', f'{name}:={topic}')
        ]
        return ['--ros-args', '--params-file', str(path), *remapped]


def mission_nodes(files: BuildingFiles, port: str) -> tuple[NodeSetup, ...]:
    """Return the six nodes.

    Args:
        files: files of the building.
        port: serial port of the motor controller.
    """
    return (
        _localizer('floor_localizer', 'floor', BELLY_MOUNT, {'map_file': str(files.dot_map)}),
        _localizer(
            'vlc_beacon',
            'ceiling',
            CEILING_MOUNT,
            {
                'beacons_file': str(files.beacons),
                'key_file': str(files.key),
                'counter_file': str(files.counters),
                'shutter': 'rolling',
                'row_time': CEILING_CAMERA.shutter.row_time,
                'exposure_time': CEILING_CAMERA.shutter.exposure,
                'lamp_frame_rate': LAMP_RATE,
                'camera_height_known': True,
                'zone_radius': COMMAND_RADIUS,
                # Without visible lamps, publish nothing instead of odometry.
                'odometry.gap_distance_max': 0.1,
                # Wheel separation 0.2 m, slip 5 mm after 1 m.
                'odometry.slip': 0.004,
                'odometry.turn_slip': 0.035,
            },
        ),
        NodeSetup(
            'stereo_landmark',
            {
                'places_dir': str(files.places),
                'image_transport': 'raw',
                **_mount(STEREO_RIG.mount),
            },
            {},
            ('/left/image_rect', '/right/image_rect'),
        ),
        NodeSetup('pose_arbiter', {}, {}),
        _planner(),
        NodeSetup(
            'motor_bridge',
            {'port': port, 'update_rate': 50.0, 'reply_timeout': 1.0, 'max_linear_velocity': CRUISE_SPEED},
            {},
        ),
    )


def _localizer(package: str, camera: str, mount: CameraMount, parameters: Mapping[str, Value]) -> NodeSetup:
    topics = {name: f'/{camera}/{name}' for name in ('image_raw', 'camera_info')}
    values = {'image_transport': 'raw', **_mount(mount), **parameters}
    return NodeSetup(package, values, topics, (f'/{camera}/image_raw',))


def _planner() -> NodeSetup:
    parameters: dict[str, Value] = {
        'source': 'depth',
        'drive': True,
        'robot_radius': ROBOT_RADIUS,
        'height_max': ROBOT_HEIGHT,
        # Depth is too noisy beyond this range.
        'range_max': 3.5,
        'max_linear_velocity': CRUISE_SPEED,
        'max_angular_velocity': 1.0,
        'max_angular_acceleration': 2.0,
        'goal_tolerance': GOAL_TOLERANCE,
        'goal_yaw_tolerance': 0.04,
        **_mount(DEPTH_MOUNT),
    }
    topics = {'pose': '/pose_arbiter/pose', 'command': '/vlc_beacon/command'}
    return NodeSetup('reward_planner', parameters, topics, ('/depth/image',))


def _mount(mount: CameraMount) -> dict[str, Value]:
    return {'camera_xyz': list(mount.xyz), 'camera_rpy': list(mount.rpy)}
