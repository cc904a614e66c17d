"""Starts the mission's simulated room and the six nodes that drive a robot through it.

Arguments: `folder` (takes the parameter files of the nodes, summary.json and track.csv) and `seed` (of room, robot
and noise). All nodes take their time from the room, which waits for them; when the mission is over, everything ends.
`./shirube demo mission` does the same without ROS's launch system.
"""

from typing import Any

from launch import LaunchDescription
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

WRITTEN = b'parameter files are written'
"""The room says so when the nodes can start."""


def generate_launch_description() -> LaunchDescription:
    """Return the room, and the nodes that follow it."""
    given = LaunchConfiguration
    # No Node action: that would add --ros-args, which the room does not know.
    room = ExecuteProcess(
        cmd=[
            ExecutableInPackage(package='shirube_mission', executable='room'),
            given('folder'),
            *('--seed', given('seed'), '--launched'),
        ],
        output='screen',
    )
    return LaunchDescription(
        [
            DeclareLaunchArgument('folder', default_value='mission', description='takes all files'),
            DeclareLaunchArgument('seed', default_value='0', description='of room, robot and noise'),
            RegisterEventHandler(OnProcessIO(target_action=room, on_stdout=follow)),
            RegisterEventHandler(OnProcessExit(target_action=room, on_exit=[EmitEvent(event=Shutdown())])),
            # Last, so that nothing the room says is missed.
            room,
        ]
    )


def follow(event: ProcessIO) -> list[GroupAction] | None:
    """Return the nodes when the room has said that their parameter files are there."""
    return parts() if WRITTEN in event.text else None


def parts() -> list[GroupAction]:
    """Return the launch file of each node with what it takes."""
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
    """Return the arguments that tell a localizer its camera."""
    return {'image': f'/{namespace}/image_raw', 'camera_info': f'/{namespace}/camera_info'}


def include(name: str, package: str, **arguments: Any) -> GroupAction:
    """Return another launch file of this package, with the parameter file that the room has written.

    In a group of its own: else what it is given would be given to those after it, too, which have arguments of the same
    name.
    """
    path = PathJoinSubstitution([FindPackageShare('shirube_bringup'), 'launch', f'{name}.launch.py'])
    arguments['params_file'] = PathJoinSubstitution([LaunchConfiguration('folder'), f'{package}.yaml'])
    arguments['use_sim_time'] = 'true'
    part = IncludeLaunchDescription(PythonLaunchDescriptionSource(path), launch_arguments=arguments.items())
    return GroupAction([part])
