"""A bag with a jump back in time."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from sensor_msgs.msg import Imu
from std_msgs.msg import Header

from shirube_core.geometry import SE2
from shirube_ros.offline.recording import RecordingTopics
from shirube_ros.pose_conversion import odometry_message
from vlc_beacon.bag_localization import BagLocalization


class Bag:
    """Messages in a row."""

    def __init__(self, *messages: tuple[str, Any]) -> None:
        self._messages = messages

    def messages(self, _: list[str]) -> Iterator[SimpleNamespace]:
        return (
            SimpleNamespace(topic=topic, message=message, msgtype='') for topic, message in self._messages
        )

    def decode(self, raw: SimpleNamespace) -> Any:
        return raw.message


class Receiver:
    """Remembers the stamps it was given."""

    def __init__(self) -> None:
        self.stamps: list[float] = []

    def add_odometry(self, stamp: float, _: SE2) -> None:
        self.stamps.append(stamp)

    def add_tilt(self, stamp: float, *_: float) -> None:
        self.stamps.append(stamp)


def header(stamp: int) -> Header:
    return Header(stamp=Time(sec=stamp))


def test_messages_after_a_jump_back_go_to_the_new_receiver() -> None:
    receivers: list[Receiver] = []

    def create_receiver() -> Receiver:
        receivers.append(Receiver())
        return receivers[-1]

    bag = Bag(
        *(
            ('/odom', odometry_message(SE2(1.0, 2.0, 0.5), np.eye(3), header(stamp), 'base_link'))
            for stamp in (100, 5, 6)
        ),
        *(('/imu', Imu(header=header(stamp))) for stamp in (7, 1)),
    )
    topics = RecordingTopics(('/image_raw',), ('/camera_info',), '/odom', '/imu')
    assert not list(BagLocalization(bag, topics, create_receiver).run())  # type: ignore[arg-type]
    assert [receiver.stamps for receiver in receivers] == [[100.0], [5.0, 6.0, 7.0], [1.0]]
