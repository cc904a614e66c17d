"""A replay and its clock, and the wait for subscribers."""

from threading import Event

import pytest

from shirube_bags.bag_reader import BagReader
from shirube_bags.errors import ReplayError
from shirube_bags.replay import ReplayClock, replay, wait_for_any, wait_for_counts


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


def play(path, rate, stop, on_progress=lambda _: None, **options):
    with BagReader(path) as bag:
        player = Recorder(tuple(bag.topics))
        result = replay(bag, player, rate, None, stop=stop, on_progress=on_progress, **options)
        return player, result, list(bag.messages())


@pytest.mark.parametrize(('rate', 'seconds'), [(0.0, 0.0), (2.0, 0.4)])
def test_all_messages_are_published_in_order_in_the_bag_s_time_over_the_rate(bag_path, rate, seconds):
    player, result, messages = play(bag_path, rate, Event())
    assert result.elapsed >= seconds
    assert player.published == messages
    assert result.messages == len(messages)
    assert result.bag_duration == pytest.approx(0.8)


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


def test_an_offset_leaves_out_the_beginning_and_the_rest_keeps_its_times(bag_path):
    player, result, messages = play(bag_path, 4.0, Event(), start_offset=0.4)
    later = [each for each in messages if each.stamp_ns >= messages[0].stamp_ns + 400_000_000]
    assert player.published == later
    assert min(player.ticks) >= later[0].stamp_ns - 25_000_000
    assert result.bag_duration == pytest.approx(0.4)


def test_nothing_is_published_during_a_pause_and_nothing_is_lost_after_it(bag_path):
    looks, published = iter([False] * 5 + [True] * 4), []

    def is_paused():
        paused = next(looks, False)
        published.append((paused, len(player.published)))
        return paused

    with BagReader(bag_path) as bag:
        player = Recorder(tuple(bag.topics))
        result = replay(bag, player, 0.0, None, stop=Event(), on_progress=lambda _: None, is_paused=is_paused)
        assert player.published == list(bag.messages())
    assert len({count for paused, count in published if paused}) == 1
    assert result.elapsed >= 4 * 0.025


def test_a_pause_delays_all_further_messages():
    pace = ReplayClock(2.0, 0, now=0.0)
    pace.pause(3.0)
    assert pace.delay(1 * SECOND, 3.0) == pytest.approx(0.5)
    assert pace.bag_time(3.5) == SECOND


SECOND = 10**9


@pytest.mark.parametrize('rate', [0.5, 1.0, 4.0])
def test_messages_are_due_at_the_bag_s_time_over_the_rate(rate):
    pace = ReplayClock(rate, 100 * SECOND, now=7.0)
    assert pace.delay(100 * SECOND, 7.0) == 0.0
    assert pace.delay(102 * SECOND, 7.0) == pytest.approx(2.0 / rate)
    assert pace.delay(102 * SECOND, 7.0 + 1.5 / rate) == pytest.approx(0.5 / rate)
    assert pace.bag_time(7.0 + 3.0 / rate) == pytest.approx(103 * SECOND)
    assert ReplayClock(0.0, 0, now=0.0).delay(10**15, 0.0) == 0.0


def test_after_a_halt_the_messages_keep_their_distances_and_small_delays_do_not_add_up():
    pace = ReplayClock(1.0, 0, now=0.0)
    assert pace.delay(1 * SECOND, 1.01) == 0.0
    assert pace.delay(2 * SECOND, 1.01) == pytest.approx(0.99)
    pace = ReplayClock(1.0, 0, now=0.0)
    assert pace.delay(1 * SECOND, 5.0) == 0.0
    assert pace.delay(2 * SECOND, 5.0) == pytest.approx(1.0)
    assert pace.bag_time(5.0) == 1 * SECOND


class Counts:
    """Subscribers that appear during the wait."""

    def __init__(self, looks_until_there):
        self.looks_until_there = dict(looks_until_there)

    def __call__(self, topic):
        self.looks_until_there[topic] -= 1
        return int(self.looks_until_there[topic] < 0)


def never():
    return False


def test_wanted_subscribers_are_waited_for():
    counts = Counts({'/a': 3, '/b': 5})
    wait_for_counts(counts, {'/a': 1, '/b': 1}, 5.0, never)
    assert counts('/a') == counts('/b') == 1


def test_missing_subscribers_are_named_with_their_numbers():
    with pytest.raises(ReplayError, match=r'missing after 0.05 s: /b has 0 of 2; start'):
        wait_for_counts(lambda topic: int(topic == '/a'), {'/a': 1, '/b': 2}, 0.05, never)


def test_a_wish_to_stop_ends_every_wait():
    wait_for_counts(lambda _topic: 0, {'/a': 1}, 30.0, lambda: True)
    wait_for_any(lambda _topic: 0, ['/a'], 30.0, lambda: True)


@pytest.mark.parametrize(
    ('subscribers', 'timeout', 'lonely'),
    [
        (lambda topic: int(topic == '/a'), 30.0, ['/b']),
        (Counts({'/a': 0, '/b': 10}), 30.0, []),  # a later subscription of the same node is waited for
        (lambda _topic: 0, 0.05, ['/a', '/b']),
    ],
)
def test_the_first_subscriber_ends_the_wait_and_lonely_topics_are_returned(subscribers, timeout, lonely):
    assert wait_for_any(subscribers, ['/a', '/b'], timeout, never) == lonely
