"""Image sequence of lamps as a bag, with raw images, odometry and tilt."""

import numpy as np

from shirube_bags.bag_reader import jazzy_types
from shirube_bags.bag_writer import BagWriter
from shirube_core.geometry import quaternion_from_yaw

TYPES = {
    '/image_raw': 'sensor_msgs/msg/Image',
    '/camera_info': 'sensor_msgs/msg/CameraInfo',
    '/odom': 'nav_msgs/msg/Odometry',
    '/imu': 'sensor_msgs/msg/Imu',
}


def message(kind, **fields):
    """Return a message of a type."""
    return jazzy_types().types[kind](**fields)


def header(stamp_ns, frame):
    """Return a header."""
    seconds, rest = divmod(stamp_ns, 1_000_000_000)
    stamp = message('builtin_interfaces/msg/Time', sec=seconds, nanosec=rest)
    return message('std_msgs/msg/Header', stamp=stamp, frame_id=frame)


def vector(kind, *numbers):
    """Return a message of x, y, z and perhaps w."""
    return message(f'geometry_msgs/msg/{kind}', **dict(zip('xyzw', map(float, numbers))))


def odometry(pose, stamp_ns):
    """Return an Odometry."""
    zeros, still = np.zeros(36), vector('Vector3', 0, 0, 0)
    place = message(
        'geometry_msgs/msg/Pose',
        position=vector('Point', pose.x, pose.y, 0.0),
        orientation=vector('Quaternion', *quaternion_from_yaw(pose.yaw)),
    )
    twist = message('geometry_msgs/msg/Twist', linear=still, angular=still)
    return message(
        TYPES['/odom'],
        header=header(stamp_ns, 'odom'),
        child_frame_id='base_link',
        pose=message('geometry_msgs/msg/PoseWithCovariance', pose=place, covariance=zeros),
        twist=message('geometry_msgs/msg/TwistWithCovariance', twist=twist, covariance=zeros),
    )


def imu(roll, pitch, stamp_ns):
    """Return an Imu that leans a little."""
    still, nine = vector('Vector3', 0, 0, 0), np.zeros(9)
    return message(
        TYPES['/imu'],
        header=header(stamp_ns, 'base_link'),
        orientation=vector('Quaternion', 0.5 * roll, 0.5 * pitch, 0.0, 1.0),
        orientation_covariance=nine,
        angular_velocity=still,
        angular_velocity_covariance=nine,
        linear_acceleration=still,
        linear_acceleration_covariance=nine,
    )


def image(pixels, stamp_ns):
    """Return a grey Image."""
    height, width = pixels.shape
    return message(
        TYPES['/image_raw'],
        header=header(stamp_ns, 'ceiling_optical_frame'),
        height=height,
        width=width,
        encoding='mono8',
        is_bigendian=0,
        step=width,
        data=pixels.ravel(),
    )


def camera_info(camera, stamp_ns):
    """Return a CameraInfo without distortion."""
    whole = message(
        'sensor_msgs/msg/RegionOfInterest', x_offset=0, y_offset=0, height=0, width=0, do_rectify=False
    )
    return message(
        TYPES['/camera_info'],
        header=header(stamp_ns, 'ceiling_optical_frame'),
        height=camera.height,
        width=camera.width,
        distortion_model='plumb_bob',
        d=np.zeros(5),
        k=camera.matrix.ravel(),
        r=np.eye(3).ravel(),
        p=np.column_stack([camera.matrix, np.zeros(3)]).ravel(),
        binning_x=0,
        binning_y=0,
        roi=whole,
    )


def write_bag(path, entries):
    """Write messages, given as (topic, stamp in ns, message)."""
    with BagWriter(path) as bag:
        for topic, stamp_ns, content in entries:
            bag.write(topic, TYPES[topic], content, stamp_ns)
