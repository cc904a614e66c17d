from pathlib import Path

import pytest
from lamp_on_a_line import lamp_that, usual

from vlc_beacon.commands import lamp_port
from vlc_beacon.commands.lamp_port import LampPort, LampStatus, check_version, read_status, upload_requests
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

pytestmark = pytest.mark.newest_set_only


def test_a_frame_is_sent_line_by_line() -> None:
    with lamp_that(usual) as (path, received), LampPort(path) as port:
        port.load(bytes(40), keep=True)
        assert port.status() == LampStatus(True, 'kept', 40, 0xFF, False)
        port.halt()
        port.play()
    assert [line[:4] for line in received] == ['v', 'b 40', 'd 0 ', 'd 32', 'k', 's', 'h', 'p']


def test_a_lamp_that_is_asleep_at_first_is_woken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lamp_port, 'RETRY_INTERVAL', 0.05)
    answers = iter(['', '', 'ERR line\r\n', 'led_beacon 1 508\r\n'])
    with (
        lamp_that(lambda line: next(answers) if line == 'v' else usual(line)) as (path, _),
        LampPort(path) as port,
    ):
        assert port.status().source == 'kept'


def test_streaming_waits_while_the_lamp_is_busy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lamp_port, 'POLL_INTERVAL', 0.0)
    busy = iter([0, 1, 1, 0, 1, 0])

    def answers(line: str) -> str:
        return f'playing temporary 4 00ff {next(busy)}\r\n' if line == 's' else usual(line)

    with lamp_that(answers) as (path, received), LampPort(path) as port:
        port.stream([b'1', b'2', b'3'])
    assert ''.join(line[0] for line in received) == 'vsbdtsssbdtssbdt'


def test_errors_of_the_lamp_are_reported() -> None:
    def answers(line: str) -> str:
        return 'ERR crc\r\n' if line == 'k' else usual(line)

    refused = pytest.raises(VlcBeaconError, match="replied 'ERR crc' to 'k'")
    with lamp_that(answers) as (path, _), LampPort(path) as port, refused:
        port.load(bytes(4), keep=True)


def test_missing_replies_time_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lamp_port, 'CONNECT_TIMEOUT', 0.1)
    monkeypatch.setattr(lamp_port, 'RETRY_INTERVAL', 0.05)
    monkeypatch.setattr(lamp_port, 'REPLY_TIMEOUT', 0.1)
    with lamp_that(lambda _: '') as (path, _), pytest.raises(VlcBeaconError, match='no lamp replies on'):
        LampPort(path)

    def answers(line: str) -> str:
        return '' if line == 's' else usual(line)

    skip_reason = pytest.raises(VlcBeaconError, match='does not reply')
    with lamp_that(answers) as (path, _), LampPort(path) as port, skip_reason:
        port.status()


def test_other_firmware_is_rejected() -> None:
    other = pytest.raises(VlcBeaconError, match='flash firmware/led_beacon')
    with lamp_that(lambda _: 'Invalid Command\r\n') as (path, _), other:
        LampPort(path)


def test_an_invalid_serial_port_is_reported(tmp_path: Path) -> None:
    with pytest.raises(VlcBeaconError, match='cannot be opened: No such file'):
        LampPort(tmp_path / 'ttyUSB0')
    (tmp_path / 'file').touch()
    with pytest.raises(VlcBeaconError, match='is not a serial port'):
        LampPort(tmp_path / 'file')


@pytest.mark.parametrize('noise', ['tick\r\n' * 400, 'x' * 4000])
def test_a_device_that_never_stops_talking_does_not_hold_us(
    noise: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lamp_port, 'CONNECT_TIMEOUT', 0.3)
    monkeypatch.setattr(lamp_port, 'RETRY_INTERVAL', 0.05)
    with lamp_that(lambda _: noise) as (path, _), pytest.raises(VlcBeaconError):
        LampPort(path)


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


def test_other_versions_are_rejected() -> None:
    check_version('led_beacon 1 508')
    for reply in ('', 'led_beacon 2 508', 'ROSArduinoBridge'):
        with pytest.raises(VlcBeaconError, match='flash firmware/led_beacon'):
            check_version(reply)
