"""Starts pose_arbiter with a parameter file.

Arguments: `params_file` (your copy of config/pose_arbiter.yaml, which names the sources), `odom` (odometry topic),
`initialpose` (topic of the initial pose), `use_sim_time` (the parameter file has precedence).
"""

from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node, SetParameter
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Return the node and the launch arguments."""
    config = PathJoinSubstitution([FindPackageShare('shirube_bringup'), 'config'])
    arguments = [
        DeclareLaunchArgument(
            'params_file',
            default_value=PathJoinSubstitution([config, 'pose_arbiter.yaml']),
            description='parameters of the node',
        ),
        DeclareLaunchArgument('odom', default_value='odom', description='topic of the odometry'),
        DeclareLaunchArgument(
            'initialpose', default_value='/initialpose', description='topic of the initial pose'
        ),
        DeclareLaunchArgument('use_sim_time', default_value='false', description='use /clock'),
    ]
    node = Node(
        package='pose_arbiter',
        executable='node',
        name='pose_arbiter',
        output='screen',
        parameters=[LaunchConfiguration('params_file')],
        remappings=[(topic, LaunchConfiguration(topic)) for topic in ('odom', 'initialpose')],
    )
    sim_time = SetParameter('use_sim_time', True, condition=IfCondition(LaunchConfiguration('use_sim_time')))
    return LaunchDescription([*arguments, sim_time, node])
