"""Starts all nodes on a robot: localizers, arbiter, planner and motor bridge.

Arguments: `floor`, `stereo`, `vlc`, `planner`, `motors` (nodes to start; all by default, but `stereo` and `vlc` only if
their file is given), `monitor` (collision_monitor between the driver and the base; give `true`), `namespace` and
`frame_prefix` (of this robot, if there are several), `config` (folder with your copies of all parameter files),
`places_dir` (taught places, for `stereo`) and `beacons_file` (lamps, for `vlc`; both default to the parameter files),
`description` (URDF or xacro file of your robot, such as the installed
`urdf/demo_robot.urdf.xacro`, for robot_state_publisher), `use_sim_time`, and `driver`, the publisher of `cmd_vel`:
`planner` (drives to goals on `goal_pose`), `lamps` (drives as the lamps command) or `none` (you drive, for example with
a joystick, on `cmd_vel`, or with the monitor on `cmd_vel_in`). Use only one: motor_bridge rejects `cmd_vel` from two
that send at once.

The belly camera publishes in the namespace `floor_camera` (default `belly`), the ceiling camera in `ceiling_camera`
(default `ceiling`), the stereo pair in `left` and `right`; the planner's sensor is set in its parameter file.
`cameras` starts camera nodes: `cameras:='belly ceiling stereo'` needs your copies of config/camera.yaml as
belly_camera.yaml and so on; `stereo` is one camera of both halves (parameter `split`), otherwise start `left right`.
"""

from functools import partial
from pathlib import Path
from typing import Any

from launch.actions import DeclareLaunchArgument, GroupAction, LogInfo, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import (
    Command,
    EqualsSubstitution,
    IfElseSubstitution,
    LaunchConfiguration,
    NotEqualsSubstitution,
)
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from launch import LaunchContext, LaunchDescription
from shirube_bringup.launching import REQUIRED, ROBOT, check_files, check_path, declare, parameter_in, share
from shirube_bringup.launching import include as include_from

given = LaunchConfiguration

PARTS = {
    'floor_localizer': 'floor',
    'stereo_landmark': 'stereo',
    'vlc_beacon': 'vlc',
    'pose_arbiter': '',
    'reward_planner': 'planner',
    'collision_monitor': 'monitor',
    'motor_bridge': 'motors',
}
"""The nodes, and the arguments that start them."""


def generate_launch_description() -> LaunchDescription:
    """Return the nodes and the launch arguments."""
    drivers = ['none', 'planner', 'lamps']
    driver = DeclareLaunchArgument('driver', default_value='none', choices=drivers, description='publisher of cmd_vel')
    arguments = {
        'floor': ('true', 'localize by dots on the floor'),
        'stereo': ('auto', 'localize by taught landmarks; auto: if places_dir is set'),
        'vlc': ('auto', 'localize by lamps on the ceiling; auto: if beacons_file is set'),
        'planner': ('true', 'map obstacles and plan paths'),
        'monitor': ('false', 'stop before people and obstacles: collision_monitor before the base'),
        'motors': ('true', 'drive the motor controller'),
        'config': (share('config'), 'folder of the parameter files'),
        'places_dir': ('', 'folder of the taught places'),
        'beacons_file': ('', 'file with the positions of the lamps'),
        'floor_camera': ('belly', 'namespace of the belly camera'),
        'ceiling_camera': ('ceiling', 'namespace of the ceiling camera'),
        'cameras': ('', 'namespaces of cameras to start; each needs <name>_camera.yaml'),
        'description': ('', 'URDF or xacro file of the robot; empty for none'),
        **ROBOT,
        'use_sim_time': ('false', 'use /clock'),
    }
    choice = OpaqueFunction(function=choose_parts)
    return LaunchDescription([driver, *declare(arguments), choice, *parts(), description()])


def choose_parts(context: LaunchContext) -> list[LogInfo | GroupAction]:
    """Leave out the localizers that are not asked for and whose file is not given; return a line for each, and cameras.

    Raises:
        MissingFileError: a file of another part is missing; no node was started yet.
    """
    check_path('description', given('description').perform(context))
    lines = []
    for node, name in PARTS.items():
        params_file = Path(given('config').perform(context)) / f'{node}.yaml'
        choice = given(name).perform(context).lower() if name else 'true'
        file = REQUIRED.get(node, 'config')
        path = given(file).perform(context)
        if choice == 'auto':
            choice = str(bool(path or parameter_in(params_file, file))).lower()
            context.launch_configurations[name] = choice
            if choice == 'false':
                remedy = f'give {file}:=PATH, or set it in {params_file}'
                lines.append(LogInfo(msg=f'{node} is left out, as {file} is not set; {remedy}'))
        if choice in ('true', '1'):
            check_files(node, params_file, {file: path})
    cameras = given('cameras').perform(context).split()
    for name in cameras:
        check_files('camera', Path(given('config').perform(context)) / f'{name}_camera.yaml', {})
    return [*lines, *map(camera_node, cameras)]


def camera_node(name: str) -> GroupAction:
    """Return the node of a camera in its namespace; that of a double image has left/ and right/ in the robot's."""
    namespace = [given('namespace'), *([] if name == 'stereo' else ['/', name])]
    robot = {'namespace': namespace, 'frame_prefix': given('frame_prefix')}
    return include_from('camera', f'{name}_camera', given('config'), given('use_sim_time'), **robot)


def parts() -> list[GroupAction]:
    """Return the launch file of each node with its arguments."""
    robot = {name: given(name) for name in ROBOT}
    include = partial(include_from, folder=given('config'), use_sim_time=given('use_sim_time'), **robot)
    commanded = IfElseSubstitution(given('monitor'), 'cmd_vel_in', 'cmd_vel')
    return [
        include('floor', 'floor_localizer', condition='floor', **camera('floor_camera')),
        include('stereo', 'stereo_landmark', condition='stereo', places_dir=given('places_dir')),
        include(
            'vlc',
            'vlc_beacon',
            condition='vlc',
            beacons_file=given('beacons_file'),
            drive=EqualsSubstitution(given('driver'), 'lamps'),
            cmd_vel=commanded,
            **camera('ceiling_camera'),
        ),
        include('arbiter', 'pose_arbiter'),
        include(
            'planner',
            'reward_planner',
            condition='planner',
            drive=EqualsSubstitution(given('driver'), 'planner'),
            cmd_vel=commanded,
        ),
        include('monitor', 'collision_monitor', condition='monitor'),
        include('bridge', 'motor_bridge', condition='motors'),
    ]


def description() -> Node:
    """Return the publisher of the frames of the robot's description, if there is one."""
    urdf = ParameterValue(Command(['xacro ', given('description')]), value_type=str)
    return Node(
        package='robot_state_publisher',
        executable='robot_state_publisher',
        namespace=given('namespace'),
        parameters=[
            {'robot_description': urdf, 'frame_prefix': given('frame_prefix'), 'use_sim_time': given('use_sim_time')}
        ],
        condition=IfCondition(NotEqualsSubstitution(given('description'), '')),
    )


def camera(argument: str) -> dict[str, list[Any]]:
    """Return the topic arguments of a localizer, from the launch argument of its camera's namespace."""
    return {'image': [given(argument), '/image_raw'], 'camera_info': [given(argument), '/camera_info']}
