"""A replay keeps the timing of the bag, publishes /clock, and can be stopped."""

from threading import Event

import pytest
from rosgraph_msgs.msg import Clock

from shirube_bags.bag_player import BagPlayer
from shirube_bags.bag_reader import BagReader
from shirube_bags.replay import replay


class Recorder:
    """A fake player."""

    def __init__(self, topics):
        self.topics = topics
        self.published = []
        self.ticks = []

    def publish(self, message):
        self.published.append(message)
        self.ticks.append(message.stamp_ns)

    def set_clock(self, stamp_ns):
        self.ticks.append(stamp_ns)


def play(path, rate, stop, on_progress=lambda _: None):
    with BagReader(path) as bag:
        player = Recorder(tuple(bag.topics))
        result = replay(bag, player, rate, None, stop=stop, on_progress=on_progress)
        return player, result, list(bag.messages())


@pytest.mark.parametrize('rate', [0.0, 4.0])
def test_all_messages_are_published_in_order(bag_path, rate):
    player, result, messages = play(bag_path, rate, Event())
    assert player.published == messages
    assert result.messages == len(messages)
    assert result.bag_duration == pytest.approx(0.8)


def test_the_replay_takes_the_bag_s_time_over_the_rate(bag_path):
    assert play(bag_path, 2.0, Event())[1].elapsed >= 0.4


def test_the_clock_rises_all_the_time_and_between_the_messages(bag_path, monkeypatch):
    monkeypatch.setattr('shirube_bags.replay.CLOCK_INTERVAL', 0.002)
    player, _, messages = play(bag_path, 1.0, Event())
    assert player.ticks == sorted(player.ticks)
    assert len(player.ticks) > 1.5 * len(messages)


def test_a_wish_to_stop_ends_the_replay(bag_path):
    stop = Event()

    def stop_halfway(played):
        if played > 0.4:
            stop.set()

    player, result, messages = play(bag_path, 0.0, stop, stop_halfway)
    assert 0 < result.messages < len(messages)
    assert len(player.published) == result.messages


def test_the_live_clock_rises(ros, bag_path):
    node, ticks = ros.node('watch'), []
    node.create_subscription(Clock, '/clock', lambda message: ticks.append(message.clock), 1000)
    with BagReader(bag_path) as bag:
        player = BagPlayer(ros.node('player'), bag.topics.values())
        while node.count_publishers('/clock') == 0:
            ros.executor.spin_once(timeout_sec=0.01)
        replay(bag, player, 0.0, None, stop=Event(), on_progress=lambda _: None)
        last = bag.end_ns
    stamps = []
    for _ in range(1000):
        stamps = [each.sec * 10**9 + each.nanosec for each in ticks]
        if stamps and stamps[-1] == last:
            break
        ros.executor.spin_once(timeout_sec=0.02)
    assert len(stamps) == len(set(stamps)) == 81
    assert stamps == sorted(stamps)
