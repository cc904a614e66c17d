"""Starts a camera node of shirube_camera with a parameter file.

Arguments: `params_file` (your copy of config/camera.yaml), `namespace` of the camera, `frame_prefix` of the robot,
`use_sim_time` (the parameter file has precedence).
"""

from launch import LaunchDescription
from shirube_bringup.launching import single_node


def generate_launch_description() -> LaunchDescription:
    """Return the node and the launch arguments."""
    return single_node('shirube_camera', {}, name='camera')
