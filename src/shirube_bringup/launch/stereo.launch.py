"""Starts stereo_landmark with a parameter file.

Arguments: `params_file` (your copy of config/stereo_landmark.yaml), `places_dir` (folder of the taught places; default:
that of the parameter file), `left` and `right` (namespaces of the two cameras), `image` (name of their image topics;
raw images if the parameter `rectify` is true), `imu` (IMU topic), `namespace` and `frame_prefix` of the robot,
`use_sim_time` (the parameter file has precedence).
"""

from launch.substitutions import LaunchConfiguration

from launch import LaunchDescription
from shirube_bringup.launching import single_node


def generate_launch_description() -> LaunchDescription:
    """Return the node and the launch arguments."""
    arguments = {
        'places_dir': ('', 'folder of the taught places'),
        'left': ('left', 'namespace of the left camera'),
        'right': ('right', 'namespace of the right camera'),
        'image': ('image_rect', 'name of the image topics'),
        'imu': ('imu', 'IMU topic'),
    }
    image = LaunchConfiguration('image')
    cameras = {side: LaunchConfiguration(side) for side in ('left', 'right')}
    topics = {
        **{f'{side}/image_rect': [camera, '/', image] for side, camera in cameras.items()},
        **{f'{side}/camera_info': [camera, '/camera_info'] for side, camera in cameras.items()},
        'imu': LaunchConfiguration('imu'),
    }
    return single_node('stereo_landmark', arguments, topics)
