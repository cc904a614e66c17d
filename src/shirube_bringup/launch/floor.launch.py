"""Starts floor_localizer with its parameter file.

Arguments: `params_file` (your own copy of config/floor_localizer.yaml), `image` (topic of the camera's
images), `camera_info` (topic of its calibration), `use_sim_time`.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Return the node and the arguments it takes."""
    parameters = PathJoinSubstitution([FindPackageShare('shirube_bringup'), 'config', 'floor_localizer.yaml'])
    arguments = [
        DeclareLaunchArgument('params_file', default_value=parameters, description='parameters of the node'),
        DeclareLaunchArgument('image', default_value='image_raw', description='topic of the images'),
        DeclareLaunchArgument(
            'camera_info', default_value='camera_info', description='topic of the calibration'
        ),
        DeclareLaunchArgument('use_sim_time', default_value='false', description='take the time from /clock'),
    ]
    node = Node(
        package='floor_localizer',
        executable='node',
        name='floor_localizer',
        output='screen',
        parameters=[
            LaunchConfiguration('params_file'),
            {'use_sim_time': ParameterValue(LaunchConfiguration('use_sim_time'), value_type=bool)},
        ],
        remappings=[
            ('image_raw', LaunchConfiguration('image')),
            ('image_raw/compressed', [LaunchConfiguration('image'), '/compressed']),
            ('camera_info', LaunchConfiguration('camera_info')),
        ],
    )
    return LaunchDescription([*arguments, node])
