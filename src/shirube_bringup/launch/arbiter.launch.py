"""Starts pose_arbiter with a parameter file.

Arguments: `params_file` (your copy of config/pose_arbiter.yaml, which names the sources), `odom` (odometry topic),
`initialpose` (topic of the initial pose), `namespace` and `frame_prefix` of the robot, `use_sim_time` (the parameter
file has precedence).
"""

from launch import LaunchDescription
from shirube_bringup.launching import single_node


def generate_launch_description() -> LaunchDescription:
    """Return the node and the launch arguments."""
    arguments = {'odom': ('odom', 'topic of the odometry'), 'initialpose': ('initialpose', 'topic of the initial pose')}
    return single_node('pose_arbiter', arguments)
