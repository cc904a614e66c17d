"""Starts the mission's simulation and the six nodes that drive a robot through it.

Arguments: `folder` (folder for the parameter files of the nodes, summary.json and track.csv) and `seed` (seed of room,
robot and noise). All nodes use the simulation's /clock, which waits for them; after the mission, everything ends.
`./shirube demo mission` does the same without ROS's launch system.
"""

from typing import Any

from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    ExecuteProcess,
    GroupAction,
    IncludeLaunchDescription,
    RegisterEventHandler,
)
from launch.event_handlers import OnProcessExit, OnProcessIO
from launch.events import Shutdown
from launch.events.process import ProcessIO
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.substitutions import ExecutableInPackage, FindPackageShare

from launch import LaunchDescription

WRITTEN = b'parameter files are written'
"""Printed by the simulation when the nodes can start."""


def generate_launch_description() -> LaunchDescription:
    """Return the simulation and the nodes, which start after it."""
    given = LaunchConfiguration
    # Not a Node action: that would add --ros-args, which the executable does not accept.
    room = ExecuteProcess(
        cmd=[
            ExecutableInPackage(package='shirube_bringup', executable='room'),
            given('folder'),
            *('--seed', given('seed'), '--launched'),
        ],
        output='screen',
    )
    return LaunchDescription(
        [
            DeclareLaunchArgument('folder', default_value='mission', description='folder for all files'),
            DeclareLaunchArgument('seed', default_value='0', description='seed of room, robot and noise'),
            RegisterEventHandler(OnProcessIO(target_action=room, on_stdout=start_nodes)),
            RegisterEventHandler(OnProcessExit(target_action=room, on_exit=[EmitEvent(event=Shutdown())])),
            # Last, so that no output is missed.
            room,
        ]
    )


def start_nodes(event: ProcessIO) -> list[GroupAction] | None:
    """Return the nodes when the simulation has written their parameter files."""
    return parts() if WRITTEN in event.text else None


def parts() -> list[GroupAction]:
    """Return the launch file of each node with its arguments."""
    building = [LaunchConfiguration('folder'), 'building']
    return [
        include('floor', 'floor_localizer', **camera('floor')),
        include('stereo', 'stereo_landmark', places_dir=PathJoinSubstitution([*building, 'places'])),
        include(
            'vlc',
            'vlc_beacon',
            beacons_file=PathJoinSubstitution([*building, 'beacons.yaml']),
            **camera('ceiling'),
        ),
        include('arbiter', 'pose_arbiter'),
        include('planner', 'reward_planner', drive='true'),
        include('bridge', 'motor_bridge'),
    ]


def camera(namespace: str) -> dict[str, str]:
    """Return the topic arguments of a localizer."""
    return {'image': f'/{namespace}/image_raw', 'camera_info': f'/{namespace}/camera_info'}


def include(name: str, package: str, **arguments: Any) -> GroupAction:
    """Include another launch file of this package, with the parameter file that the simulation has written.

    The group limits the scope of the arguments; otherwise they would also be set for the next files, which have
    arguments of the same name.
    """
    path = PathJoinSubstitution([FindPackageShare('shirube_bringup'), 'launch', f'{name}.launch.py'])
    arguments['params_file'] = PathJoinSubstitution([LaunchConfiguration('folder'), f'{package}.yaml'])
    arguments['use_sim_time'] = 'true'
    part = IncludeLaunchDescription(PythonLaunchDescriptionSource(path), launch_arguments=arguments.items())
    return GroupAction([part])
