"""Starts stereo_landmark with a parameter file.

Arguments: `params_file` (your copy of config/stereo_landmark.yaml), `places_dir` (folder of the taught places; default:
that of the parameter file), `left` and `right` (namespaces of the two cameras), `image` (name of their image topics;
raw images if the parameter `rectify` is true), `imu` (IMU topic), `use_sim_time` (the parameter file has precedence).
"""

from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node, SetParameter
from launch_ros.substitutions import FindPackageShare

from launch import LaunchContext, LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Return the node and the launch arguments."""
    config = PathJoinSubstitution([FindPackageShare('shirube_bringup'), 'config'])
    arguments = [
        DeclareLaunchArgument(
            'params_file',
            default_value=PathJoinSubstitution([config, 'stereo_landmark.yaml']),
            description='parameters of the node',
        ),
        DeclareLaunchArgument('places_dir', default_value='', description='folder of the taught places'),
        DeclareLaunchArgument('left', default_value='left', description='namespace of the left camera'),
        DeclareLaunchArgument('right', default_value='right', description='namespace of the right camera'),
        DeclareLaunchArgument('image', default_value='image_rect', description='name of the image topics'),
        DeclareLaunchArgument('imu', default_value='imu', description='IMU topic'),
        DeclareLaunchArgument('use_sim_time', default_value='false', description='use /clock'),
    ]
    sim_time = SetParameter('use_sim_time', True, condition=IfCondition(LaunchConfiguration('use_sim_time')))
    return LaunchDescription([*arguments, sim_time, OpaqueFunction(function=start_node)])


def start_node(context: LaunchContext) -> list[Node]:
    """Return the node; an empty `places_dir` leaves that of the parameter file."""
    places_dir = LaunchConfiguration('places_dir').perform(context)
    image = LaunchConfiguration('image')
    cameras = {side: LaunchConfiguration(side) for side in ('left', 'right')}
    return [
        Node(
            package='stereo_landmark',
            executable='node',
            name='stereo_landmark',
            output='screen',
            parameters=[
                LaunchConfiguration('params_file'),
                *([{'places_dir': places_dir}] if places_dir else []),
            ],
            remappings=[
                *((f'{side}/image_rect', [camera, '/', image]) for side, camera in cameras.items()),
                *((f'{side}/camera_info', [camera, '/camera_info']) for side, camera in cameras.items()),
                ('imu', LaunchConfiguration('imu')),
            ],
        )
    ]
