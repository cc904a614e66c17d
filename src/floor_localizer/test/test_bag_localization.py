"""A bag whose clock jumps back."""

from types import SimpleNamespace

import numpy as np
from builtin_interfaces.msg import Time
from std_msgs.msg import Header

from floor_localizer.bag_localization import BagLocalization
from shirube_core.geometry import SE2
from shirube_ros.offline.recording import RecordingTopics
from shirube_ros.pose_conversion import odometry_message


class Tracker:
    """Records the stamps it receives."""

    def __init__(self):
        self.stamps = []

    def add_odometry(self, stamp, _):
        self.stamps.append(stamp)


def odometry(stamp):
    header = Header(stamp=Time(sec=stamp))
    return odometry_message(SE2(1.0, 2.0, 0.5), np.eye(3), header, 'base_link')


def test_odometry_after_a_jump_back_goes_to_the_new_tracker():
    rows = [SimpleNamespace(topic='/odom', msgtype='', message=odometry(stamp)) for stamp in (100, 5, 6)]
    bag = SimpleNamespace(messages=lambda _: iter(rows), decode=lambda row: row.message)
    trackers = []

    def create_tracker():
        trackers.append(Tracker())
        return trackers[-1]

    topics = RecordingTopics(('/image_raw',), ('/camera_info',), '/odom')
    assert not list(BagLocalization(bag, topics, create_tracker).run())
    assert [tracker.stamps for tracker in trackers] == [[100.0], [5.0, 6.0]]
