from vlc_beacon.core.authorization.zone_visits import ZoneVisits
from vlc_beacon.core.packet.command_packet import Command


def test_a_rule_is_done_until_the_zone_is_left_for_good() -> None:
    visits = ZoneVisits({1: (0.0, 0.0), 2: (5.0, 0.0)}, 1.0)
    first, second = Command(1, 3, 0.2, 5), Command(1, 5, 1.0, 5)
    visits.update_position((0.5, 0.0))
    visits.mark_executed(first)
    assert visits.is_executed(first)
    assert not visits.is_executed(second)
    assert not visits.is_executed(Command(2, 3, 0.2, 5))
    for x in (0.9, 1.1, 0.9, 1.2):
        visits.update_position((x, 0.0))
        assert visits.is_executed(first)
    visits.update_position((1.3, 0.0))
    assert not visits.is_executed(first)


def test_a_new_counter_is_a_new_rule() -> None:
    visits = ZoneVisits({1: (0.0, 0.0)}, 1.0)
    visits.mark_executed(Command(1, 3, 0.2, 5))
    assert not visits.is_executed(Command(1, 3, 0.2, 6))


def test_distances_are_those_in_the_plane() -> None:
    visits = ZoneVisits({1: (1.0, 2.0)}, 1.0)
    assert visits.distance(1, (4.0, 6.0)) == 5.0
    assert visits.distance(7, (4.0, 6.0)) is None
    assert visits.is_within(1.0)
    assert not visits.is_within(1.001)
    assert not visits.is_within(float('nan'))
