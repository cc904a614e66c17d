"""Starts reward_planner with a parameter file.

Arguments: `params_file` (your copy of config/reward_planner.yaml), `drive` (whether the planner drives the robot; has
precedence over the parameter file), `points` (point cloud topic), `pose` (topic of the robot's pose), `command` (topic
of the lamps' commands), `cmd_vel` (topic of the velocities), `namespace` and `frame_prefix` of the robot,
`use_sim_time` (the parameter file has precedence).
"""

from launch import LaunchDescription
from shirube_bringup.launching import single_node


def generate_launch_description() -> LaunchDescription:
    """Return the node and the launch arguments."""
    arguments = {
        'drive': ('false', 'whether the planner drives the robot'),
        'points': ('points', 'point cloud topic'),
        'pose': ('pose_arbiter/pose', "topic of the robot's pose"),
        'command': ('vlc_beacon/command', "topic of the lamps' commands"),
        'cmd_vel': ('cmd_vel', 'topic of the velocities'),
    }
    return single_node('reward_planner', arguments)
