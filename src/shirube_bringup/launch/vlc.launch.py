"""Starts vlc_beacon with a parameter file.

Arguments: `params_file` (your copy of config/vlc_beacon.yaml), `beacons_file` (positions of the lamps; default: that of
the parameter file), `image` (image topic), `camera_info` (CameraInfo topic), `drive` (whether the lamps drive the
robot; has precedence over the parameter file), `cmd_vel` (topic of the velocities), `use_sim_time` (the parameter file
has precedence).
"""

from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node, SetParameter
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from launch import LaunchContext, LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Return the node and the launch arguments."""
    config = PathJoinSubstitution([FindPackageShare('shirube_bringup'), 'config'])
    arguments = [
        DeclareLaunchArgument(
            'params_file',
            default_value=PathJoinSubstitution([config, 'vlc_beacon.yaml']),
            description='parameters of the node',
        ),
        DeclareLaunchArgument(
            'beacons_file', default_value='', description='file with the positions of the lamps'
        ),
        DeclareLaunchArgument('image', default_value='image_raw', description='image topic'),
        DeclareLaunchArgument('camera_info', default_value='camera_info', description='CameraInfo topic'),
        DeclareLaunchArgument(
            'drive', default_value='false', description='whether the lamps drive the robot'
        ),
        DeclareLaunchArgument('cmd_vel', default_value='~/cmd_vel', description='topic of the velocities'),
        DeclareLaunchArgument('use_sim_time', default_value='false', description='use /clock'),
    ]
    sim_time = SetParameter('use_sim_time', True, condition=IfCondition(LaunchConfiguration('use_sim_time')))
    return LaunchDescription([*arguments, sim_time, OpaqueFunction(function=start_node)])


def start_node(context: LaunchContext) -> list[Node]:
    """Return the node; an empty `beacons_file` leaves that of the parameter file."""
    beacons_file = LaunchConfiguration('beacons_file').perform(context)
    return [
        Node(
            package='vlc_beacon',
            executable='node',
            name='vlc_beacon',
            output='screen',
            parameters=[
                LaunchConfiguration('params_file'),
                {'drive': ParameterValue(LaunchConfiguration('drive'), value_type=bool)},
                *([{'beacons_file': beacons_file}] if beacons_file else []),
            ],
            remappings=[
                ('image_raw', LaunchConfiguration('image')),
                ('camera_info', LaunchConfiguration('camera_info')),
                ('~/cmd_vel', LaunchConfiguration('cmd_vel')),
            ],
        )
    ]
