"""Starts collision_monitor with a parameter file; it limits the velocities of `cmd_vel_in` before they reach the base.

Arguments: `params_file` (your copy of config/collision_monitor.yaml), `cmd_vel_in` (topic of the commander), `cmd_vel`
(topic of the base), `odom` (odometry, optional), `namespace` and `frame_prefix` of the robot, `use_sim_time` (the
parameter file has precedence). The topics of the range sensors are in the parameter file.
"""

from launch import LaunchDescription
from shirube_bringup.launching import single_node


def generate_launch_description() -> LaunchDescription:
    """Return the node and the launch arguments."""
    arguments = {
        'cmd_vel_in': ('cmd_vel_in', 'topic of the commanded velocities'),
        'cmd_vel': ('cmd_vel', 'topic of the limited velocities'),
        'odom': ('odom', 'topic of the odometry'),
    }
    return single_node('reward_planner', arguments, name='collision_monitor')
