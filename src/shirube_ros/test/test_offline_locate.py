"""Localization of a bag whose clock jumps back; the rest is tested with the commands of the localizers."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from sensor_msgs.msg import Imu
from std_msgs.msg import Header

from shirube_core.geometry import SE2
from shirube_ros.camera.info import camera_from_camera_info
from shirube_ros.offline.locate import OfflineLocalizer, locate_recording
from shirube_ros.offline.recording import Recording, RecordingTopics
from shirube_ros.pose_conversion import odometry_message


def row(topic: str, stamp: int) -> Any:
    header = Header(stamp=Time(sec=stamp))
    odometry = odometry_message(SE2(1.0, 2.0, 0.5), np.eye(3), header, 'base_link')
    return SimpleNamespace(
        topic=topic, msgtype='', message=odometry if topic == '/odom' else Imu(header=header)
    )


def test_messages_after_a_jump_back_go_to_the_new_localizer() -> None:
    rows = [row('/odom', stamp) for stamp in (100, 5, 6)] + [row('/imu', stamp) for stamp in (7, 1)]
    bag: Any = SimpleNamespace(messages=lambda _: iter(rows), decode=lambda row: row.message)
    taken: list[list[float]] = []

    def create() -> OfflineLocalizer[Any, str]:
        stamps: list[float] = []
        taken.append(stamps)
        return OfflineLocalizer(
            lambda *_: None, lambda stamp, _: stamps.append(stamp), lambda stamp, *_: stamps.append(stamp)
        )

    topics = RecordingTopics(('/image_raw',), ('/camera_info',), '/odom', '/imu')
    assert not list(locate_recording(Recording(bag, topics, camera_from_camera_info), create, ()))
    assert taken == [[100.0], [5.0, 6.0, 7.0], [1.0]]
