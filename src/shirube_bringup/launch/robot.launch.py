"""Starts all nodes on a robot: localizers, arbiter, planner and motor bridge.

Arguments: `floor`, `stereo`, `vlc`, `planner`, `motors` (nodes to start; all by default), `config` (folder with your
copies of all parameter files), `places_dir` (taught places, for `stereo`) and `beacons_file` (lamps, for `vlc`; both
default to the parameter files), `use_sim_time`, and `driver`, the publisher of `cmd_vel`: `planner` (drives to goals on
`goal_pose`), `lamps` (drives as the lamps command) or `none` (you drive, for example with a joystick). Use only one:
motor_bridge rejects `cmd_vel` from two publishers.

The belly camera publishes in the namespace `floor_camera` (default `belly`), the ceiling camera in `ceiling_camera`
(default `ceiling`), the stereo pair in `left` and `right`; the planner's sensor is set in its parameter file.
"""

from typing import Any

from launch.actions import DeclareLaunchArgument, GroupAction, IncludeLaunchDescription
from launch.conditions import IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import EqualsSubstitution, LaunchConfiguration, PathJoinSubstitution
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Return the nodes and the launch arguments."""
    config = PathJoinSubstitution([FindPackageShare('shirube_bringup'), 'config'])
    defaults = {
        'floor': ('true', 'localize by dots on the floor'),
        'stereo': ('true', 'localize by taught landmarks'),
        'vlc': ('true', 'localize by lamps on the ceiling'),
        'planner': ('true', 'map obstacles and plan paths'),
        'motors': ('true', 'drive the motor controller'),
        'config': (config, 'folder of the parameter files'),
        'places_dir': ('', 'folder of the taught places'),
        'beacons_file': ('', 'file with the positions of the lamps'),
        'floor_camera': ('belly', 'namespace of the belly camera'),
        'ceiling_camera': ('ceiling', 'namespace of the ceiling camera'),
        'use_sim_time': ('false', 'use /clock'),
    }
    driver = DeclareLaunchArgument(
        'driver',
        default_value='none',
        choices=['none', 'planner', 'lamps'],
        description='publisher of cmd_vel',
    )
    return LaunchDescription(
        [
            driver,
            *(
                DeclareLaunchArgument(name, default_value=d, description=t)
                for name, (d, t) in defaults.items()
            ),
            *parts(),
        ]
    )


def parts() -> list[GroupAction]:
    """Return the launch file of each node with its arguments."""
    given = LaunchConfiguration
    return [
        include('floor', 'floor_localizer', 'floor', **camera('floor_camera')),
        include('stereo', 'stereo_landmark', 'stereo', places_dir=given('places_dir')),
        include(
            'vlc',
            'vlc_beacon',
            'vlc',
            beacons_file=given('beacons_file'),
            drive=EqualsSubstitution(given('driver'), 'lamps'),
            cmd_vel='cmd_vel',
            **camera('ceiling_camera'),
        ),
        include('arbiter', 'pose_arbiter', None),
        include('planner', 'reward_planner', 'planner', drive=EqualsSubstitution(given('driver'), 'planner')),
        include('bridge', 'motor_bridge', 'motors'),
    ]


def camera(argument: str) -> dict[str, list[Any]]:
    """Return the topic arguments of a localizer, from the launch argument of its camera's namespace."""
    namespace = LaunchConfiguration(argument)
    return {'image': [namespace, '/image_raw'], 'camera_info': [namespace, '/camera_info']}


def include(name: str, package: str, condition: str | None, **arguments: Any) -> GroupAction:
    """Include another launch file of this package, with its parameter file from the folder `config`.

    The group limits the scope of the arguments; otherwise they would also be set for the next files, which have
    arguments of the same name.
    """
    path = PathJoinSubstitution([FindPackageShare('shirube_bringup'), 'launch', f'{name}.launch.py'])
    arguments['params_file'] = PathJoinSubstitution([LaunchConfiguration('config'), f'{package}.yaml'])
    arguments['use_sim_time'] = LaunchConfiguration('use_sim_time')
    part = IncludeLaunchDescription(PythonLaunchDescriptionSource(path), launch_arguments=arguments.items())
    return GroupAction([part], condition=IfCondition(LaunchConfiguration(condition)) if condition else None)
