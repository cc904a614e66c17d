"""Replays a bag into localizers, arbiter and planner; the motors stay off.

Arguments: `bag` (its folder), `rate` (times real time; 0 as fast as the nodes go), `wait_for` (the bag begins when
somebody listens to this topic: take the pictures of the localizer that starts last, such as
`/belly/image_raw/compressed`, to lose nothing of the beginning), and of `robot.launch.py` all but `driver`, `motors`
and `use_sim_time`.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, EmitEvent, IncludeLaunchDescription, RegisterEventHandler
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


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
            # At their very first start the nodes compile their loops.
            *('--wait-for', LaunchConfiguration('wait_for'), '--timeout', '300'),
        ],
    )
    return LaunchDescription(
        [
            DeclareLaunchArgument('bag', description='folder of the bag'),
            DeclareLaunchArgument('rate', default_value='1.0', description='times real time; 0: full speed'),
            DeclareLaunchArgument('wait_for', default_value='/odom', description='topic with a listener'),
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(suite),
                launch_arguments={'driver': 'none', 'motors': 'false', 'use_sim_time': 'true'}.items(),
            ),
            player,
            RegisterEventHandler(OnProcessExit(target_action=player, on_exit=[EmitEvent(event=Shutdown())])),
        ]
    )
