from functools import partial

from vlc_beacon.core.authorization.keys_and_counters import Counters
from vlc_beacon.core.packet.command_packet import Command


def rule(counter: int, beacon: int = 1, *, is_one_shot: bool = False) -> Command:
    return Command(beacon, 1, 0.0, counter, is_one_shot)


one_shot = partial(rule, is_one_shot=True)


def test_beacons_and_kinds_are_counted_apart() -> None:
    counters = Counters().advance(rule(5)).advance(one_shot(9, 2))
    assert all(counters.is_new(new) for new in (one_shot(1), rule(1, 2), rule(1, 3)))
    assert not counters.is_new(one_shot(9, 2))


def test_the_floor_applies_to_beacons_without_a_counter() -> None:
    counters = Counters(floor=100).advance(rule(150, 2))
    assert [counters.is_new(rule(c)) for c in (99, 100)] == [False, True]
    assert [counters.is_new(one_shot(c)) for c in (100, 101)] == [False, True]
    assert not counters.is_new(rule(149, 2))
