"""Starts vlc_beacon with a parameter file.

Arguments: `params_file` (your copy of config/vlc_beacon.yaml), `beacons_file` (positions of the lamps; default: that of
the parameter file), `image` (image topic), `camera_info` (CameraInfo topic), `drive` (whether the lamps drive the
robot; has precedence over the parameter file), `cmd_vel` (topic of the velocities), `namespace` and `frame_prefix` of
the robot, `use_sim_time` (the parameter file has precedence).
"""

from launch.substitutions import LaunchConfiguration

from launch import LaunchDescription
from shirube_bringup.launching import single_node


def generate_launch_description() -> LaunchDescription:
    """Return the node and the launch arguments."""
    arguments = {
        'beacons_file': ('', 'file with the positions of the lamps'),
        'image': ('image_raw', 'image topic'),
        'camera_info': ('camera_info', 'CameraInfo topic'),
        'drive': ('false', 'whether the lamps drive the robot'),
        'cmd_vel': ('~/cmd_vel', 'topic of the velocities'),
    }
    topics = {'image_raw': 'image', 'camera_info': 'camera_info', '~/cmd_vel': 'cmd_vel'}
    remapped = {topic: LaunchConfiguration(argument) for topic, argument in topics.items()}
    return single_node('vlc_beacon', arguments, remapped)
