from vlc_beacon.core.packet.id_confirmation import IdConfirmation


def test_an_id_is_believed_when_it_came_twice_in_a_row() -> None:
    confirmation = IdConfirmation()
    assert [confirmation.add(beacon) for beacon in (1, 2, 1, 1, 1, 2, 2)] == [None, None, None, 1, 1, None, 2]
