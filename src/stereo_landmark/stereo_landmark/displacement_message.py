"""The displacement from a taught place as a message."""

from __future__ import annotations

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
from std_msgs.msg import Header

from shirube_geometry import quaternion_from_yaw
from stereo_landmark.core.landmark_fix import LandmarkFix


def displacement_message(fix: LandmarkFix, stamp: Time, base_frame: str) -> TransformStamped:
    """Return the level base of the robot in the frame of the place, which is called like the place.

    Args:
        fix: the robot at a place.
        stamp: of the left image.
        base_frame: frame of the robot.
    """
    pose = fix.displacement.T_place_base
    x, y, z, w = quaternion_from_yaw(pose.yaw)
    return TransformStamped(
        header=Header(stamp=stamp, frame_id=fix.place.name),
        child_frame_id=base_frame,
        transform=Transform(
            translation=Vector3(x=pose.x, y=pose.y, z=fix.displacement.height),
            rotation=Quaternion(x=x, y=y, z=z, w=w),
        ),
    )
