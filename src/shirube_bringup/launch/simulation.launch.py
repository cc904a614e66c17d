"""Starts the mission's simulation and the nodes that drive a robot through it.

Arguments: `folder` (folder for the parameter files of the nodes, summary.json and track.csv) and `seed` (seed of room,
robot and noise). All nodes use the simulation's /clock, which waits for them; after the mission, everything ends.
`./shirube demo mission` does the same without ROS's launch system.
"""

from functools import partial

from launch.actions import ExecuteProcess, GroupAction, RegisterEventHandler, Shutdown
from launch.event_handlers import OnProcessIO
from launch.events.process import ProcessIO
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.substitutions import ExecutableInPackage

from launch import LaunchDescription
from shirube_bringup.launching import declare
from shirube_bringup.launching import include as include_from

WRITTEN = b'parameter files are written'
"""Printed by the simulation when the nodes can start."""


def generate_launch_description() -> LaunchDescription:
    """Return the simulation and the nodes, which start after it."""
    # Not a Node action: that would add --ros-args, which the executable does not accept.
    executable = ExecutableInPackage(package='shirube_bringup', executable='room')
    options = [LaunchConfiguration('folder'), '--seed', LaunchConfiguration('seed'), '--launched']
    room = ExecuteProcess(cmd=[executable, *options], output='screen', on_exit=Shutdown())
    return LaunchDescription(
        [
            *declare({'folder': ('mission', 'folder for all files'), 'seed': ('0', 'seed of room, robot and noise')}),
            RegisterEventHandler(OnProcessIO(target_action=room, on_stdout=start_nodes)),
            # Last, so that no output is missed.
            room,
        ]
    )


def start_nodes(event: ProcessIO) -> list[GroupAction] | None:
    """Return the nodes when the simulation has written their parameter files."""
    return parts() if WRITTEN in event.text else None


def parts() -> list[GroupAction]:
    """Return the launch file of each node with its arguments."""
    folder = LaunchConfiguration('folder')
    include = partial(include_from, folder=folder, use_sim_time='true')
    beacons, places = (PathJoinSubstitution([folder, 'building', name]) for name in ('beacons.yaml', 'places'))
    return [
        include('floor', 'floor_localizer', **camera('floor')),
        include('stereo', 'stereo_landmark', places_dir=places),
        include('vlc', 'vlc_beacon', beacons_file=beacons, **camera('ceiling')),
        include('arbiter', 'pose_arbiter'),
        include('planner', 'reward_planner', drive='true', cmd_vel='cmd_vel_in'),
        include('monitor', 'collision_monitor'),
        include('bridge', 'motor_bridge'),
    ]


def camera(namespace: str) -> dict[str, str]:
    """Return the topic arguments of a localizer."""
    return {'image': f'/{namespace}/image_raw', 'camera_info': f'/{namespace}/camera_info'}
