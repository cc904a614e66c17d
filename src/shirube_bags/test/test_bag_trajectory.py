"""Poses and stamps come from the headers of a bag's messages."""

import numpy as np
import pytest

from shirube_bags.bag_reader import BagReader, jazzy_types
from shirube_bags.bag_writer import BagWriter
from shirube_bags.errors import BagError
from shirube_bags.trajectory_files import load_bag_trajectory, load_header_stamps

START_NS = 1_700_000_000_123_456_789
TYPES = jazzy_types().types
POINT = TYPES['geometry_msgs/msg/Point'](1.0, 2.0, 3.0)
TURN = TYPES['geometry_msgs/msg/Quaternion'](0.0, 0.6, 0.0, 0.8)
POSE = TYPES['geometry_msgs/msg/Pose'](POINT, TURN)
WITH_COVARIANCE = TYPES['geometry_msgs/msg/PoseWithCovariance'](POSE, np.zeros(36))
VECTOR = TYPES['geometry_msgs/msg/Vector3'](1.0, 2.0, 3.0)
TWIST = TYPES['geometry_msgs/msg/TwistWithCovariance'](
    TYPES['geometry_msgs/msg/Twist'](VECTOR, VECTOR), np.zeros(36)
)
CONTENTS = {
    'geometry_msgs/msg/PoseStamped': (POSE,),
    'geometry_msgs/msg/PoseWithCovarianceStamped': (WITH_COVARIANCE,),
    'nav_msgs/msg/Odometry': ('base_link', WITH_COVARIANCE, TWIST),
    'geometry_msgs/msg/TransformStamped': ('base_link', TYPES['geometry_msgs/msg/Transform'](VECTOR, TURN)),
}


@pytest.mark.parametrize('msgtype', CONTENTS)
def test_every_message_with_a_pose_is_understood(tmp_path, messages, msgtype):
    with BagWriter(tmp_path / 'bag') as bag:
        for stamp in (START_NS, START_NS + 7):
            bag.write(
                '/pose', msgtype, TYPES[msgtype](messages.header(stamp), *CONTENTS[msgtype]), stamp + 10**9
            )
    with BagReader(tmp_path / 'bag') as bag:
        trajectory = load_bag_trajectory(bag, None)
    assert trajectory.stamps_ns.tolist() == [START_NS, START_NS + 7]
    np.testing.assert_allclose(trajectory.positions, [[1, 2, 3]] * 2)
    np.testing.assert_allclose(trajectory.quaternions, [[0, 0.6, 0, 0.8]] * 2)


def test_header_stamps_are_those_of_the_decoded_messages(bag_path):
    with BagReader(bag_path) as bag:
        stamps = load_header_stamps(bag, '/image_raw')
        decoded = [bag.decode(each).header.stamp for each in bag.messages(['/image_raw'])]
    assert stamps.tolist() == [each.sec * 10**9 + each.nanosec for each in decoded]


def test_several_topics_with_poses_are_named(tmp_path, messages):
    with BagWriter(tmp_path / 'bag') as bag:
        for topic in ('/b', '/a'):
            bag.write(topic, 'geometry_msgs/msg/PoseStamped', messages.pose(START_NS, 0, 0, 0), 1)
    with BagReader(tmp_path / 'bag') as bag, pytest.raises(BagError, match='/a, /b have poses; name one'):
        load_bag_trajectory(bag, None)


def test_a_topic_without_poses_is_refused(bag_path):
    with BagReader(bag_path) as bag, pytest.raises(BagError, match='/true_pose have poses'):
        load_bag_trajectory(bag, '/image_raw')


def test_malformed_poses_are_refused_with_their_topic(tmp_path, messages):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.write('/pose', 'geometry_msgs/msg/PoseStamped', messages.pose(START_NS, np.nan, 0, 0), 1)
    with (
        BagReader(tmp_path / 'bag') as bag,
        pytest.raises(BagError, match='/pose: pose 1 of 1 has a position'),
    ):
        load_bag_trajectory(bag, None)


def test_messages_without_a_header_have_no_stamps(tmp_path, messages):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.write('/text', 'std_msgs/msg/String', messages.text('x'), 1)
    with BagReader(tmp_path / 'bag') as bag, pytest.raises(BagError, match='has no header'):
        load_header_stamps(bag, '/text')
