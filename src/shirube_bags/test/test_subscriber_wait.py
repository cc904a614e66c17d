"""The wait for subscribers depends on their number, not on time alone."""

import pytest

from shirube_bags.errors import ReplayError
from shirube_bags.replay import wait_for_any, wait_for_counts


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


def test_the_first_subscriber_ends_the_wait_and_lonely_topics_are_returned():
    assert wait_for_any(lambda topic: int(topic == '/a'), ['/a', '/b'], 30.0, never) == ['/b']


def test_a_later_subscription_of_the_same_node_is_waited_for():
    assert wait_for_any(Counts({'/a': 0, '/b': 10}), ['/a', '/b'], 30.0, never) == []


def test_without_any_subscriber_all_topics_are_lonely():
    assert wait_for_any(lambda _topic: 0, ['/a', '/b'], 0.05, never) == ['/a', '/b']


def test_a_wish_to_stop_ends_every_wait():
    wait_for_counts(lambda _topic: 0, {'/a': 1}, 30.0, lambda: True)
    wait_for_any(lambda _topic: 0, ['/a'], 30.0, lambda: True)
