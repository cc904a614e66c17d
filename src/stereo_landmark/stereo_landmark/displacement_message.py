"""Conversion of the displacement from a taught place to a message."""

from __future__ import annotations

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
from std_msgs.msg import Header

from shirube_core.geometry import quaternion_from_yaw
from stereo_landmark.core.landmark_fix import LandmarkFix


def displacement_message(fix: LandmarkFix, stamp: Time, base_frame: str) -> TransformStamped:
    """Return the pose of the gravity-aligned base in the place frame, whose frame ID is the name of the place.

    Args:
        fix: localization result.
        stamp: stamp of the left image.
        base_frame: frame ID of the robot base.
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
