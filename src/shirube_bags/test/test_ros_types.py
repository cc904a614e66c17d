"""Message classes are found by their names."""

import pytest
from sensor_msgs.msg import Image

from shirube_bags.bag_player import load_message_class
from shirube_bags.errors import ReplayError


def test_an_installed_type_is_found():
    assert load_message_class('sensor_msgs/msg/Image') is Image


@pytest.mark.parametrize('msgtype', ['my_msgs/msg/Thing', 'sensor_msgs/msg/Thing', 'nonsense', ''])
def test_an_unknown_type_is_refused_in_one_line(msgtype):
    with pytest.raises(ReplayError, match='not installed; install'):
        load_message_class(msgtype)
