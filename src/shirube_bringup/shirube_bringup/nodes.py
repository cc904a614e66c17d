"""The mission's nodes: their parameters and topics, and their processes."""

import os
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType, TracebackType
from typing import Self

import yaml

from motor_bridge.core.diff_drive_kinematics import DriveSettings
from scene_simulator.mission.layout import (
    BELLY_MOUNT,
    CEILING_CAMERA,
    CEILING_MOUNT,
    LAMP_RATE,
    ROBOT_HEIGHT,
    ROBOT_RADIUS,
)
from scene_simulator.mission.sensors import DEPTH_MOUNT, STEREO_RIG
from shirube_bringup.building import CRUISE_SPEED, BuildingFiles
from shirube_core.geometry import CameraMount

Value = str | bool | int | float | list[float] | list[str]
COMMAND_RADIUS = 2.0  # radius around a lamp in which its commands are obeyed [m]
GOAL_TOLERANCE = 0.01  # goal tolerance of the planner [m]
AREA = 'pose_arbiter/initialpose'  # topic of the area where floor_localizer searches first, from the other localizers
PLANNERS: Mapping[str, Mapping[str, Value]] = {
    'default': {},
    'paper': {'rule': 'count', 'mode': 'reward', 'visits': 'counted', 'look_around': True},
}
"""Parameters of the planner by name: shortest routes, or the paper's map and reward rule, with visits counted."""

DEPTH_RANGE = 3.5  # depth is too noisy beyond this range [m]
_SHUTDOWN_TIMEOUT = 10.0  # timeout after SIGINT [s]


class MissionError(Exception):
    """The mission cannot continue; the message is one line with reason and remedy."""


@dataclass(frozen=True)
class NodeSetup:
    """Command line of a node.

    Attributes:
        package: node name, which is also that of the package unless there is a module.
        parameters: parameters that differ from the default.
        topics: remapped topics.
        images: resolved image topics that are subscribed to reliably.
        namespace: namespace of the node.
        module: what Python runs; empty for the module ``node`` of the package.
    """

    package: str
    parameters: Mapping[str, Value]
    topics: Mapping[str, str]
    images: tuple[str, ...] = ()
    namespace: str = ''
    module: str = ''

    @property
    def name(self) -> str:
        """Name in a namespace, for files and processes."""
        return f'{self.namespace}_{self.package}'.strip('_')

    def arguments(self, folder: Path) -> list[str]:
        """Write the parameters to a file in a folder and return the node's command line."""
        values: dict[str, Value] = {'use_sim_time': True, **self.parameters}
        for topic in self.images:
            values[f'qos_overrides.{topic}.subscription.reliability'] = 'reliable'
        path = folder / f'{self.name}.yaml'
        path.write_text(yaml.safe_dump({'/**': {'ros__parameters': values}}))
        remapped = [argument for name, topic in self.topics.items() for argument in ('-r', f'{name}:={topic}')]
        if self.namespace:
            remapped += ['-r', f'__ns:=/{self.namespace}']
        return ['--ros-args', '--params-file', str(path), *remapped]


_BRIDGE = {'update_rate': 50.0, 'reply_timeout': 1.0, 'max_linear_velocity': CRUISE_SPEED, 'keep_estop': False}


def mission_nodes(files: BuildingFiles, port: str, planner: str = 'default') -> tuple[NodeSetup, ...]:
    """Return the nodes, given the serial port of the motor controller and one of `PLANNERS`."""
    return (
        _localizer(
            'floor_localizer',
            'floor',
            BELLY_MOUNT,
            {'map_file': str(files.dot_map), 'tracker.initialpose_is_strict': False},
            {'initialpose': AREA},
        ),
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
            {'places_dir': str(files.places), 'image_transport': 'raw', **_mount(STEREO_RIG.mount)},
            {},
            ('/left/image_rect', '/right/image_rect'),
        ),
        NodeSetup('pose_arbiter', {'initialpose_for': 'floor_localizer'}, {}),
        _planner(PLANNERS[planner]),
        _collision_monitor(),
        NodeSetup('motor_bridge', {'port': port, **_BRIDGE}, {}),
    )


def _localizer(
    package: str,
    camera: str,
    mount: CameraMount,
    parameters: Mapping[str, Value],
    topics: Mapping[str, str] = MappingProxyType({}),
) -> NodeSetup:
    topics = {name: f'/{camera}/{name}' for name in ('image_raw', 'camera_info')} | dict(topics)
    values = {'image_transport': 'raw', **_mount(mount), **parameters}
    return NodeSetup(package, values, topics, (f'/{camera}/image_raw',))


def _planner(method: Mapping[str, Value]) -> NodeSetup:
    parameters: dict[str, Value] = {
        'source': 'depth',
        'drive': True,
        'robot_radius': ROBOT_RADIUS,
        'height_max': ROBOT_HEIGHT,
        'range_max': DEPTH_RANGE,
        'max_linear_velocity': CRUISE_SPEED,
        'max_angular_velocity': 1.0,
        'max_angular_acceleration': 2.0,
        'slow_distance': 0.12,  # the collision monitor stops it before any contact
        'goal_tolerance': GOAL_TOLERANCE,
        'goal_yaw_tolerance': 0.04,
        'planning_thread': False,
        **_mount(DEPTH_MOUNT),
        **method,
    }
    topics = {'pose': 'pose_arbiter/pose', 'command': 'vlc_beacon/command', 'cmd_vel': 'cmd_vel_in'}
    return NodeSetup('reward_planner', parameters, topics, ('/depth/image',))


def _collision_monitor() -> NodeSetup:
    driving = DriveSettings()
    parameters: dict[str, Value] = {
        'robot_radius': ROBOT_RADIUS,
        'deceleration': driving.max_linear_acceleration,
        'angular_deceleration': driving.max_angular_acceleration,
        'front.type': 'depth',
        'front.xyz': list(DEPTH_MOUNT.xyz),
        'front.rpy': list(DEPTH_MOUNT.rpy),
        'front.range_max': DEPTH_RANGE,
        'front.height_max': ROBOT_HEIGHT,
    }
    module = 'reward_planner.commands.collision_monitor'
    return NodeSetup('collision_monitor', parameters, {}, ('/depth/image',), module=module)


def _mount(mount: CameraMount) -> dict[str, Value]:
    return {'camera_xyz': list(mount.xyz), 'camera_rpy': list(mount.rpy)}


class NodeProcesses:
    """Runs nodes in a `with` statement, ends them with SIGINT; then ``exit_codes`` are known by name."""

    def __init__(self, nodes: Sequence[NodeSetup], folder: Path, domain: int) -> None:
        """Set the nodes to run in a ROS domain, and the folder of their parameter files and logs."""
        self._nodes, self._folder, self._domain = nodes, folder, domain
        self._running: dict[str, subprocess.Popen[bytes]] = {}
        self.exit_codes: dict[str, int] = {}

    def __enter__(self) -> Self:
        """Start all nodes at once."""
        environment = {
            **os.environ,
            'ROS_DOMAIN_ID': str(self._domain),
            'ROS_LOG_DIR': str(self._folder / 'log'),
            # Eight processes on two cores: more threads would only compete.
            'OMP_NUM_THREADS': '1',
            'OPENBLAS_NUM_THREADS': '1',
        }
        for node in self._nodes:
            command = [sys.executable, '-m', node.module or f'{node.package}.node', *node.arguments(self._folder)]
            with (self._folder / f'{node.name}.log').open('wb') as log:
                self._running[node.name] = subprocess.Popen(
                    command,
                    env=environment,
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    start_new_session=True,
                )
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End all nodes with SIGINT, then with SIGKILL after a timeout."""
        for process in self._running.values():
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
        for name, process in self._running.items():
            try:
                self.exit_codes[name] = process.wait(_SHUTDOWN_TIMEOUT)
            except subprocess.TimeoutExpired:
                process.kill()
                self.exit_codes[name] = process.wait()

    def cpu_times(self) -> dict[str, float]:
        """Return the CPU time of each running node [s], by name."""
        times = {}
        for name, process in self._running.items():
            if process.poll() is not None:
                continue
            fields = Path(f'/proc/{process.pid}/stat').read_text().rpartition(')')[2].split()
            times[name] = (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')
        return times

    def has_ended(self) -> bool:
        """Return whether a node has ended unexpectedly."""
        return any(process.poll() is not None for process in self._running.values())

    def check(self) -> None:
        """Raise a MissionError that names its log if a node has ended."""
        for name, process in self._running.items():
            if process.poll() is not None:
                log = self._folder / f'{name}.log'
                raise MissionError(f'{name} ended with exit code {process.returncode}; see {log}')
