"""QoS profiles of a bag are offered again, and always reliably."""

import pytest
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSCompatibility,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
    qos_profile_sensor_data,
)
from rosbags.interfaces import QosDurability, QosReliability

from shirube_bags.bag_player import replay_qos
from shirube_bags.bag_reader import BagTopic
from shirube_bags.bag_recorder import offered_qos, recording_qos
from shirube_bags.bag_writer import reliable_qos

LATCHED = QoSProfile(depth=3, durability=DurabilityPolicy.TRANSIENT_LOCAL)
RELIABLE = QoSProfile(depth=10)


class Endpoint:
    def __init__(self, qos_profile):
        self.qos_profile = qos_profile


@pytest.mark.parametrize('subscriber', [RELIABLE, qos_profile_sensor_data])
@pytest.mark.parametrize('stored', [(), (reliable_qos(),), (reliable_qos(1, latched=True),)])
def test_a_replayed_topic_serves_every_usual_subscriber(stored, subscriber):
    profile = replay_qos(BagTopic('/a', 'std_msgs/msg/String', 5, stored))
    assert qos_check_compatible(profile, subscriber)[0] != QoSCompatibility.ERROR


def test_nothing_is_discarded_before_it_is_acknowledged():
    assert replay_qos(BagTopic('/a', 'std_msgs/msg/String', 5, ())).history == HistoryPolicy.KEEP_ALL
    latched = BagTopic('/map', 'nav_msgs/msg/OccupancyGrid', 50, (reliable_qos(1, latched=True),))
    assert replay_qos(latched).depth >= 50


def test_latched_topics_stay_latched():
    topic = BagTopic('/map', 'nav_msgs/msg/OccupancyGrid', 5, (reliable_qos(1, latched=True),))
    assert qos_check_compatible(replay_qos(topic), LATCHED)[0] != QoSCompatibility.ERROR


@pytest.mark.parametrize(
    'publishers',
    [
        [RELIABLE],
        [qos_profile_sensor_data],
        [LATCHED],
        [LATCHED, qos_profile_sensor_data],
        [LATCHED, RELIABLE],
    ],
)
def test_a_recorder_is_compatible_with_every_publisher(publishers):
    subscriber = recording_qos([Endpoint(each) for each in publishers])
    assert all(qos_check_compatible(each, subscriber)[0] != QoSCompatibility.ERROR for each in publishers)


def test_the_recorder_asks_for_all_that_is_offered():
    assert recording_qos([Endpoint(RELIABLE)]).reliability == ReliabilityPolicy.RELIABLE
    assert recording_qos([Endpoint(LATCHED)]).durability == DurabilityPolicy.TRANSIENT_LOCAL


def test_the_bag_stores_what_was_offered():
    assert offered_qos([Endpoint(LATCHED)]) == reliable_qos(3, latched=True)
    both = offered_qos([Endpoint(LATCHED), Endpoint(qos_profile_sensor_data)])
    assert both.reliability is QosReliability.BEST_EFFORT
    assert both.durability is QosDurability.VOLATILE
