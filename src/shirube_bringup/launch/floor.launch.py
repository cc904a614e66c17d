"""Starts floor_localizer with a parameter file.

Arguments: `params_file` (your copy of config/floor_localizer.yaml), `image` (image topic), `camera_info` (CameraInfo
topic), `namespace` and `frame_prefix` of the robot, `use_sim_time` (the parameter file has precedence).
"""

from launch.substitutions import LaunchConfiguration

from launch import LaunchDescription
from shirube_bringup.launching import single_node


def generate_launch_description() -> LaunchDescription:
    """Return the node and the launch arguments."""
    arguments = {'image': ('image_raw', 'image topic'), 'camera_info': ('camera_info', 'CameraInfo topic')}
    topics = {'image_raw': LaunchConfiguration('image'), 'camera_info': LaunchConfiguration('camera_info')}
    return single_node('floor_localizer', arguments, topics)
