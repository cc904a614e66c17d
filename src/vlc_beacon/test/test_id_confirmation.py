from vlc_beacon.core.packet.id_confirmation import IdConfirmation


def test_an_id_is_confirmed_by_two_consecutive_packets() -> None:
    confirmation = IdConfirmation()
    assert [confirmation.add(beacon) for beacon in (1, 2, 1, 1, 1, 2, 2)] == [None, None, None, 1, 1, None, 2]
