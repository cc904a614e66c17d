"""Messages with the same stamp are grouped, in any order of arrival."""

from itertools import permutations

from shirube_ros.stamps import StampSynchronizer


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
