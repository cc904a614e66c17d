"""Starts reward_planner with a parameter file.

Arguments: `params_file` (your copy of config/reward_planner.yaml), `drive` (whether the planner drives the robot; has
precedence over the parameter file), `points` (point cloud topic), `pose` (topic of the robot's pose), `command` (topic
of the lamps' commands), `use_sim_time` (the parameter file has precedence).
"""

from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node, SetParameter
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Return the node and the launch arguments."""
    config = PathJoinSubstitution([FindPackageShare('shirube_bringup'), 'config'])
    arguments = [
        DeclareLaunchArgument(
            'params_file',
            default_value=PathJoinSubstitution([config, 'reward_planner.yaml']),
            description='parameters of the node',
        ),
        DeclareLaunchArgument(
            'drive', default_value='false', description='whether the planner drives the robot'
        ),
        DeclareLaunchArgument('points', default_value='points', description='point cloud topic'),
        DeclareLaunchArgument(
            'pose', default_value='/pose_arbiter/pose', description="topic of the robot's pose"
        ),
        DeclareLaunchArgument(
            'command', default_value='/vlc_beacon/command', description="topic of the lamps' commands"
        ),
        DeclareLaunchArgument('use_sim_time', default_value='false', description='use /clock'),
    ]
    node = Node(
        package='reward_planner',
        executable='node',
        name='reward_planner',
        output='screen',
        parameters=[
            LaunchConfiguration('params_file'),
            {'drive': ParameterValue(LaunchConfiguration('drive'), value_type=bool)},
        ],
        remappings=[(topic, LaunchConfiguration(topic)) for topic in ('points', 'pose', 'command')],
    )
    sim_time = SetParameter('use_sim_time', True, condition=IfCondition(LaunchConfiguration('use_sim_time')))
    return LaunchDescription([*arguments, sim_time, node])
