"""Validation of stamps and synchronization by them."""

from collections.abc import Callable, Sequence
from itertools import permutations

import pytest
from node_testing import header

from shirube_ros.stamps import StampError, StampSynchronizer, StampValidator


class Watched:
    def __init__(self, now: Callable[[], float] | None = None) -> None:
        self.jumps = 0
        self.order = StampValidator(self._count, now)

    def _count(self) -> None:
        self.jumps += 1

    def take(self, topic: str, *stamps: float) -> None:
        for stamp in stamps:
            assert self.order.check(header(stamp), topic) == pytest.approx(stamp, abs=1e-6)

    def refuse(self, topic: str, *stamps: float) -> None:
        for stamp in stamps:
            with pytest.raises(StampError, match='came out of order'):
                self.order.check(header(stamp), topic)


@pytest.mark.parametrize('now', [None, lambda: 0.0])  # before simulated time begins there is nothing to compare with
def test_stamps_may_grow_and_repeat_and_topics_are_independent(now: Callable[[], float] | None) -> None:
    watched = Watched(now)
    watched.take('image', 10.0, 10.5, 10.5, 1e9)
    watched.take('odom', 0.0, 5.0, 6.0)
    assert watched.jumps == 0


@pytest.mark.parametrize(
    ('stamp', 'words'), [(99.9, 'came out of order'), (0.0, 'has a stamp of 0'), (151.0, 'has a stamp in the future')]
)
def test_a_stamp_that_is_no_time_of_now_is_refused_and_the_order_goes_on(stamp: float, words: str) -> None:
    watched = Watched(lambda: 101.0)
    watched.take('pose', 100.0)
    with pytest.raises(StampError, match=f'pose {words}'):
        watched.order.check(header(stamp), 'pose')
    watched.take('pose', 100.1, 101.9)
    assert watched.jumps == 0


def test_a_jump_back_is_reported_once_and_starts_all_topics_again() -> None:
    watched = Watched()
    watched.take('image', 100.0)
    watched.take('odom', 100.0)
    watched.refuse('odom', 3.0, 3.1)
    watched.refuse('image', 3.0)
    watched.take('image', 3.1, 3.2)
    watched.take('odom', 3.2)
    assert watched.jumps == 1


@pytest.mark.parametrize(
    'stamps',
    [
        (98.0,),  # one message was late
        (98.0, 97.0, 96.0, 95.0, 94.0, 93.0),  # not in order either
        (98.0, 0.1, 98.1, 0.2, 98.2, 0.3),  # of two publishers
        (98.0, 98.1, 98.2, 98.3),
    ],
)
def test_old_stamps_without_support_are_refused_and_nothing_is_reset(stamps: Sequence[float]) -> None:
    watched = Watched()
    watched.take('cloud', 100.0)
    watched.take('pose', 100.0)
    watched.refuse('cloud', *stamps)
    watched.take('pose', 100.1)
    watched.take('cloud', 100.1)
    assert watched.jumps == 0


@pytest.mark.parametrize('silent', [True, False])
def test_a_topic_alone_needs_a_longer_run_while_the_others_are_silent(silent: bool) -> None:
    watched = Watched()
    watched.take('image', 100.0)
    watched.take('odom', 100.0)
    watched.refuse('image', 3.0, 3.1, 3.2, 3.3)
    if silent:
        watched.take('image', 3.4, 3.5)
    else:
        watched.take('odom', 100.1)
        watched.refuse('image', 3.4, 3.5)
    assert watched.jumps == silent


def test_a_simulation_that_begins_again_is_a_jump_back_although_old_messages_come_late() -> None:
    now = [100.0]
    watched = Watched(lambda: now[0])
    watched.take('pose', 100.0)
    now[0] = 0.5
    with pytest.raises(StampError):
        watched.order.check(header(100.1), 'pose')
    watched.take('pose', 0.5, 0.6)
    assert watched.jumps == 1


def test_a_group_is_whole_in_any_order() -> None:
    for order in permutations('abc'):
        groups: StampSynchronizer[str] = StampSynchronizer('abc', 0.01)
        answers = [groups.put(name, 5.0 + 0.002 * i, name.upper()) for i, name in enumerate(order)]
        assert answers == [None, None, ('A', 'B', 'C')]


def test_items_without_partners_are_dropped_and_counted() -> None:
    groups: StampSynchronizer[int] = StampSynchronizer('ab', 0.01)
    for number in range(3):
        assert groups.put('a', float(number), number) is None
    assert groups.put('b', 2.0, 7) == (2, 7)
    assert groups.dropped == 2
    assert groups.put('b', 1.0, 8) is None
    for number in range(30):
        groups.put('a', 10.0 + number, number)
    assert groups.dropped == 2 + 20
    groups.clear()
    assert groups.put('b', 39.0, 9) is None


def test_the_topics_that_lack_are_named() -> None:
    groups: StampSynchronizer[int] = StampSynchronizer(('left', 'right', 'top'), 0.01)
    assert groups.missing_topics == ('left', 'right', 'top')
    groups.put('left', 1.0, 1)
    groups.put('right', 1.0, 2)
    assert groups.missing_topics == ('top',)
    groups.put('top', 1.5, 3)
    assert groups.missing_topics == ()
    assert groups.completed == 0
    groups.put('top', 1.0, 4)
    assert (groups.completed, groups.dropped) == (1, 1)
