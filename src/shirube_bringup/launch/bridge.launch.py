"""Starts motor_bridge with a parameter file.

Arguments: `params_file` (your copy of config/motor_bridge.yaml), `cmd_vel` (topic of the velocities), `estop` (topic of
the emergency stop), `namespace` and `frame_prefix` of the robot, `use_sim_time` (the parameter file has precedence).
"""

from launch import LaunchDescription
from shirube_bringup.launching import single_node


def generate_launch_description() -> LaunchDescription:
    """Return the node and the launch arguments."""
    arguments = {'cmd_vel': ('cmd_vel', 'topic of the velocities'), 'estop': ('estop', 'topic of the emergency stop')}
    return single_node('motor_bridge', arguments)
