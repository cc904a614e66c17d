"""Replays a bag to localizers, arbiter and planner, without motor_bridge.

Arguments: `bag` (folder of the bag), `rate` (playback rate; 0: as fast as the nodes keep up), `wait_for` (the replay
starts when this topic has a subscriber; use the images of the localizer that starts last, such as
`/belly/image_raw/compressed`, to lose no message), and those of `robot.launch.py` except `driver`, `motors` and
`use_sim_time`.
"""

from launch.actions import DeclareLaunchArgument, EmitEvent, IncludeLaunchDescription, RegisterEventHandler
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Return the nodes, the player, and the arguments they take."""
    suite = PathJoinSubstitution([FindPackageShare('shirube_bringup'), 'launch', 'robot.launch.py'])
    player = Node(
        package='shirube_bags',
        executable='play',
        output='screen',
        arguments=[
            LaunchConfiguration('bag'),
            *('--rate', LaunchConfiguration('rate')),
            # At the first start, the nodes compile numba kernels.
            *('--wait-for', LaunchConfiguration('wait_for'), '--timeout', '300'),
        ],
    )
    return LaunchDescription(
        [
            DeclareLaunchArgument('bag', description='folder of the bag'),
            DeclareLaunchArgument(
                'rate', default_value='1.0', description='playback rate; 0: as fast as the nodes keep up'
            ),
            DeclareLaunchArgument(
                'wait_for', default_value='/odom', description='start when this topic has a subscriber'
            ),
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(suite),
                launch_arguments={'driver': 'none', 'motors': 'false', 'use_sim_time': 'true'}.items(),
            ),
            player,
            RegisterEventHandler(OnProcessExit(target_action=player, on_exit=[EmitEvent(event=Shutdown())])),
        ]
    )
