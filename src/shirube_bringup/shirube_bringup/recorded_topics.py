"""Topics of the recorded bag, by the kind of their recording time."""

from __future__ import annotations

from collections.abc import Mapping

from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, TwistStamped
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from sensor_msgs.msg import CameraInfo, Imu, JointState
from std_msgs.msg import String

TOPICS_AT_STAMP: Mapping[str, type] = {
    '/ground_truth': PoseStamped,
    '/imu': Imu,
    '/odom': Odometry,
    '/joint_states': JointState,
    '/pose_arbiter/pose': PoseStamped,
    '/pose_arbiter/odometry': Odometry,
}
"""Topics recorded at the time of their header stamp."""

TOPICS_AT_STEP: Mapping[str, type] = {
    **{
        f'/{name}/{kind}': message
        for name in ('floor_localizer', 'vlc_beacon', 'stereo_landmark')
        for kind, message in (('pose', PoseStamped), ('pose_with_covariance', PoseWithCovarianceStamped))
    },
    '/vlc_beacon/command': String,
    '/goal_pose': PoseStamped,
    '/reward_planner/map': OccupancyGrid,
    '/reward_planner/local_map': OccupancyGrid,
    '/reward_planner/plan': Path,
    '/reward_planner/next_waypoint': PoseStamped,
    '/cmd_vel': TwistStamped,
}
"""Topics recorded at the current time step, with latency or without a stamp."""

CAMERA_INFOS: Mapping[str, type] = dict.fromkeys(
    (f'/{camera}/camera_info' for camera in ('floor', 'ceiling', 'left', 'right', 'depth')), CameraInfo
)
"""CameraInfo topics, recorded with the images."""

PICTURES: Mapping[str, int] = {
    '/floor/image_raw': 90,
    '/ceiling/image_raw': 60,
    '/left/image_rect': 85,
    '/right/image_rect': 85,
}
"""Topics of grey images, and the quality of their JPEG compression."""

DEPTH = '/depth/image'

EXTRACT_MS = (14_000, 34_000)
"""Mission times between which images are recorded [ms]: from the carpet over the first goal onto dots."""
