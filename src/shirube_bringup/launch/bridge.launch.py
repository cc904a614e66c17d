"""Starts motor_bridge with a parameter file.

Arguments: `params_file` (your copy of config/motor_bridge.yaml), `cmd_vel` (topic of the velocities), `estop` (topic of
the emergency stop), `use_sim_time` (the parameter file has precedence).
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
            default_value=PathJoinSubstitution([config, 'motor_bridge.yaml']),
            description='parameters of the node',
        ),
        DeclareLaunchArgument('cmd_vel', default_value='cmd_vel', description='topic of the velocities'),
        DeclareLaunchArgument('estop', default_value='estop', description='topic of the emergency stop'),
        DeclareLaunchArgument('use_sim_time', default_value='false', description='use /clock'),
    ]
    node = Node(
        package='motor_bridge',
        executable='node',
        name='motor_bridge',
        output='screen',
        parameters=[LaunchConfiguration('params_file')],
        remappings=[(topic, LaunchConfiguration(topic)) for topic in ('cmd_vel', 'estop')],
    )
    sim_time = SetParameter('use_sim_time', True, condition=IfCondition(LaunchConfiguration('use_sim_time')))
    return LaunchDescription([*arguments, sim_time, node])
