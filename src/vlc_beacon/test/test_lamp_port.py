from pathlib import Path

import pytest
from lamp_on_a_line import lamp_that, usual

from vlc_beacon import lamp_port
from vlc_beacon.core.transmitter.serial_protocol import LampStatus
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError
from vlc_beacon.lamp_port import LampPort

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
