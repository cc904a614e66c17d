"""Replays a bag to localizers, arbiter and planner, without motor_bridge.

Arguments: `bag` (folder of the bag), `rate` (playback rate; 0: as fast as the nodes keep up), `wait_for` (the replay
starts when this topic has a subscriber; use the images of the localizer that starts last, such as
`/belly/image_raw/compressed`, to lose no message), and those of `robot.launch.py` except `driver`, `motors` and
`use_sim_time`. With `namespace`, the nodes subscribe to topics of that name; the bag is that of a robot in it.
"""

from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction, Shutdown
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from launch import LaunchDescription
from shirube_bringup.launching import check_path, declare, share


def generate_launch_description() -> LaunchDescription:
    """Return the nodes, the player, and the arguments they take."""
    # At the first start, the nodes compile numba kernels.
    options = ['--rate', LaunchConfiguration('rate'), '--wait-for', LaunchConfiguration('wait_for'), '--timeout', '300']
    player = Node(
        package='shirube_bags',
        executable='play',
        output='screen',
        arguments=[LaunchConfiguration('bag'), *options],
        on_exit=Shutdown(),
    )
    arguments = {
        'rate': ('1.0', 'playback rate; 0: as fast as the nodes keep up'),
        'wait_for': ('/odom', 'start when this topic has a subscriber'),
    }
    robot = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(share('launch', 'robot.launch.py')),
        launch_arguments={'driver': 'none', 'motors': 'false', 'use_sim_time': 'true'}.items(),
    )
    bag = DeclareLaunchArgument('bag', description='folder of the bag')
    check = OpaqueFunction(function=lambda where: check_path('bag', LaunchConfiguration('bag').perform(where)))
    return LaunchDescription([bag, *declare(arguments), check, robot, player])
