import pytest

from vlc_beacon.core.transmitter.serial_protocol import (
    LampStatus,
    check_version,
    read_status,
    upload_requests,
)
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError


def test_upload_holds_every_byte_once_and_in_order() -> None:
    frame = bytes(range(70))
    first, *chunks, last = upload_requests(frame, keep=True)
    assert (first, last) == ('b 70', 'k')
    assert upload_requests(frame, keep=False)[-1] == 't'
    received = b''
    for chunk in chunks:
        word, offset, content = chunk.split()
        assert word == 'd'
        assert int(offset) == len(received)
        received += bytes.fromhex(content)
    assert received == frame


def test_lines_fit_into_the_lamps_buffer() -> None:
    assert max(map(len, upload_requests(bytes(508), keep=True))) <= 80


def test_status_is_read() -> None:
    assert read_status('playing kept 49 7c6d 1') == LampStatus(True, 'kept', 49, 0x7C6D, True)
    assert read_status('steady none 0 0000 0') == LampStatus(False, 'none', 0, 0, False)


@pytest.mark.parametrize('reply', ['', 'OK', 'playing kept x 7c6d 0', 'playing kept 49 7c6d 0 0'])
def test_a_malformed_status_is_rejected(reply: str) -> None:
    with pytest.raises(VlcBeaconError, match='not a status'):
        read_status(reply)


def test_other_firmware_is_rejected() -> None:
    check_version('led_beacon 1 508')
    for reply in ('', 'led_beacon 2 508', 'ROSArduinoBridge'):
        with pytest.raises(VlcBeaconError, match='flash firmware/led_beacon'):
            check_version(reply)
