"""Starts the whole suite on a robot: localizers, arbiter, planner and motors.

Arguments: `floor`, `stereo`, `vlc`, `planner`, `motors` (which parts run; all by default), `config` (the folder with
your own copies of all parameter files), `places_dir` (the taught places, for `stereo`) and `beacons_file` (the lamps,
for `vlc`; both by default as the parameter files say), `use_sim_time`, and `driver`: who drives the robot on `cmd_vel`:
`planner` (to the goals on `goal_pose`), `lamps` (as they say) or `none` (you do, with a joystick). It is one of them:
motor_bridge obeys nobody while two publish there.

The belly camera publishes in the namespace `floor_camera`, the one that looks up in `ceiling_camera` (`belly` and
`ceiling` by default), the pair in `left` and `right`; what the planner sees with stands in its parameter file.
"""

from typing import Any

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction, IncludeLaunchDescription
from launch.conditions import IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import EqualsSubstitution, LaunchConfiguration, PathJoinSubstitution
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Return the nodes and the arguments they take."""
    config = PathJoinSubstitution([FindPackageShare('shirube_bringup'), 'config'])
    defaults = {
        'floor': ('true', 'find the robot by dots on the floor'),
        'stereo': ('true', 'find it by taught landmarks'),
        'vlc': ('true', 'find it by lamps on the ceiling'),
        'planner': ('true', 'map obstacles and plan routes'),
        'motors': ('true', 'talk to the motor controller'),
        'config': (config, 'folder of the parameter files'),
        'places_dir': ('', 'folder of the taught places'),
        'beacons_file': ('', 'the lamps and their places'),
        'floor_camera': ('belly', 'namespace of the camera that looks at the floor'),
        'ceiling_camera': ('ceiling', 'namespace of the camera that looks at the lamps'),
        'use_sim_time': ('false', 'take the time from /clock'),
    }
    driver = DeclareLaunchArgument(
        'driver',
        default_value='none',
        choices=['none', 'planner', 'lamps'],
        description='who drives the robot on cmd_vel',
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
    """Return the launch file of each part with what it takes from the arguments."""
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
    """Return the arguments that tell a localizer its camera, whose namespace is an argument of this file."""
    namespace = LaunchConfiguration(argument)
    return {'image': [namespace, '/image_raw'], 'camera_info': [namespace, '/camera_info']}


def include(name: str, package: str, condition: str | None, **arguments: Any) -> GroupAction:
    """Return another launch file of this package, with the parameter file from the folder of them.

    In a group of its own: else what it is given would be given to those after it, too, which have arguments of the same
    name.
    """
    path = PathJoinSubstitution([FindPackageShare('shirube_bringup'), 'launch', f'{name}.launch.py'])
    arguments['params_file'] = PathJoinSubstitution([LaunchConfiguration('config'), f'{package}.yaml'])
    arguments['use_sim_time'] = LaunchConfiguration('use_sim_time')
    part = IncludeLaunchDescription(PythonLaunchDescriptionSource(path), launch_arguments=arguments.items())
    return GroupAction([part], condition=IfCondition(LaunchConfiguration(condition)) if condition else None)
