"""Starts floor_localizer with a parameter file.

Arguments: `params_file` (your copy of config/floor_localizer.yaml), `image` (image topic), `camera_info` (CameraInfo
topic), `use_sim_time` (the parameter file has precedence).
"""

from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node, SetParameter
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Return the node and the launch arguments."""
    parameters = PathJoinSubstitution([FindPackageShare('shirube_bringup'), 'config', 'floor_localizer.yaml'])
    arguments = [
        DeclareLaunchArgument('params_file', default_value=parameters, description='parameters of the node'),
        DeclareLaunchArgument('image', default_value='image_raw', description='image topic'),
        DeclareLaunchArgument('camera_info', default_value='camera_info', description='CameraInfo topic'),
        DeclareLaunchArgument('use_sim_time', default_value='false', description='use /clock'),
    ]
    node = Node(
        package='floor_localizer',
        executable='node',
        name='floor_localizer',
        output='screen',
        parameters=[LaunchConfiguration('params_file')],
        remappings=[
            ('image_raw', LaunchConfiguration('image')),
            ('camera_info', LaunchConfiguration('camera_info')),
        ],
    )
    sim_time = SetParameter('use_sim_time', True, condition=IfCondition(LaunchConfiguration('use_sim_time')))
    return LaunchDescription([*arguments, sim_time, node])
