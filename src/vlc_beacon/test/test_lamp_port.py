from pathlib import Path

import pytest
from lamp_on_a_line import lamp_that, usual

from vlc_beacon.commands import encode
from vlc_beacon.commands.encode import LampPort, upload_requests
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

pytestmark = pytest.mark.newest_set_only


@pytest.fixture(autouse=True)
def _short_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(encode, 'CONNECT_TIMEOUT', 0.3)
    monkeypatch.setattr(encode, 'RETRY_INTERVAL', 0.05)
    monkeypatch.setattr(encode, 'REPLY_TIMEOUT', 0.1)


def test_a_lamp_that_is_asleep_at_first_is_woken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(encode, 'CONNECT_TIMEOUT', 5.0)
    answers = iter(['', '', 'ERR line\r\n', 'led_beacon 1 508\r\n'])
    with (
        lamp_that(lambda line: next(answers) if line == 'v' else usual(line)) as (path, received),
        LampPort(path) as port,
    ):
        port.load(bytes(4), keep=False)
    assert received == ['v'] * 4 + ['b 4', 'd 0 00000000', 't']


@pytest.mark.parametrize(
    ('request_', 'answer', 'message'),
    [
        ('k', 'ERR crc\r\n', "replied 'ERR crc' to 'k'"),
        ('b 4', '', 'does not reply'),
        ('v', '', 'no lamp replies on'),
        ('v', 'Invalid Command\r\n', 'flash firmware/led_beacon'),
        ('v', 'led_beacon 2 508\r\n', 'flash firmware/led_beacon'),
        ('v', 'tick\r\n' * 100, 'flash firmware/led_beacon'),
        ('v', 'x' * 210, 'no lamp replies on'),
    ],
)
def test_errors_of_the_lamp_are_reported(request_: str, answer: str, message: str) -> None:
    with (
        lamp_that(lambda line: answer if line == request_ else usual(line)) as (path, _),
        pytest.raises(VlcBeaconError, match=message),
        LampPort(path) as port,
    ):
        port.load(bytes(4), keep=True)


def test_an_invalid_serial_port_is_reported(tmp_path: Path) -> None:
    with pytest.raises(VlcBeaconError, match='cannot be opened: No such file'):
        LampPort(tmp_path / 'ttyUSB0')
    (tmp_path / 'file').touch()
    with pytest.raises(VlcBeaconError, match='is not a serial port'):
        LampPort(tmp_path / 'file')


def test_upload_holds_every_byte_once_and_in_order() -> None:
    frame = bytes(range(70))
    first, *chunks, last = upload_requests(frame, keep=True)
    assert (first, last) == ('b 70', 'k')
    # Lines fit into the lamp's buffer.
    assert max(map(len, upload_requests(bytes(508), keep=True))) <= 80
    assert upload_requests(frame, keep=False)[-1] == 't'
    received = b''
    for chunk in chunks:
        word, offset, content = chunk.split()
        assert word == 'd'
        assert int(offset) == len(received)
        received += bytes.fromhex(content)
    assert received == frame
