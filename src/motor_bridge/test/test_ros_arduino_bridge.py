"""Requests and replies of the protocol."""

import re

import numpy as np
import pytest
from emulated_line import EmulatedLine

from motor_bridge.core.controller_protocol import (
    BadReplyError,
    ControllerSetup,
    WheelCounts,
    with_checksum,
    without_checksum,
)
from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.core.ros_arduino_bridge import (
    RosArduinoBridge,
    check_acknowledged,
    gains_request,
    parse_baud,
    parse_counts,
    speeds_request,
)


def test_commands_are_ended_by_a_carriage_return_alone():
    assert speeds_request(-12, 30) == b'm -12 30\r'
    assert gains_request(20, 12, 0, 50) == b'u 20:12:0:50\r'
    assert parse_baud(b'57600\r\n') == 57600


@pytest.mark.parametrize('pair', [(32768, 0), (0, -40000)])
def test_speeds_of_more_than_16_bits_are_never_sent(pair):
    with pytest.raises(MotorBridgeError, match='at most 32767'):
        speeds_request(*pair)


def test_counts_are_read():
    for left, right in ((0, 0), (-5, 17), (2**31 - 1, -(2**31))):
        assert parse_counts(f'{left} {right}\r\n'.encode()) == WheelCounts(left, right)


@pytest.mark.parametrize(
    ('parse', 'words', 'good', 'bad'),
    [
        (parse_counts, 'instead of two counts', b'5 6\r\n', [
            b'', b'\r\n', b'5\r\n', b'5 6\n', b'5 6\r', b'5 6', b' 5 6\r\n', b'5  6\r\n', b'5 6 \r\n',
            b'5 6 7\r\n', b'+5 6\r\n', b'5 --6\r\n', b'5 6\r\n\r\n', b'OK\r\n', b'nan nan\r\n', b'1e3 2\r\n',
            b'5.0 6\r\n', b'5\x006\r\n', b'\xd9\xa5 \xd9\xa6\r\n', b'2147483648 0\r\n', b'0 -2147483649\r\n',
            b'99999999999 1\r\n',
        ]),
        (check_acknowledged, 'instead of OK', b'OK\r\n',
         [b'', b'OK', b'OK\n', b'ok\r\n', b'OKOK\r\n', b'Invalid Command\r\n']),
        (parse_baud, 'instead of a baud rate', b'57600\r\n',
         [b'', b'OK\r\n', b'576\x0000\r\n', b'57600', b'-57600\r\n', b'57600 1\r\n']),
    ],
)  # fmt: skip
def test_any_other_reply_is_refused_in_printable_words(parse, words, good, bad):
    parse(good)
    for reply in bad:
        with pytest.raises(BadReplyError, match=words) as refusal:
            parse(reply)
        assert re.fullmatch(r'[ -~]+', str(refusal.value))


def test_random_bytes_are_refused_and_nothing_else_happens():
    rng = np.random.default_rng(1)
    alphabet = np.frombuffer(b'0123456789- \r\n\x00OKe', dtype=np.uint8)
    strict = re.compile(rb'-?\d+ -?\d+\r\n')
    for _ in range(5000):
        reply = rng.choice(alphabet, rng.integers(0, 12)).tobytes()
        try:
            parse_counts(reply)
        except BadReplyError:
            continue
        assert strict.fullmatch(reply)


SETUP = ControllerSetup(57600, (20, 12, 0, 50), 0.25)


@pytest.mark.parametrize(
    ('firmware', 'slowest_reply', 'auto_stop'),
    [
        ('ros_arduino_bridge', 0.02, np.inf),
        ('motor_controller', 0.02, 0.25),
        ('motor_controller', 0.1, 0.6),
        ('motor_controller', 0.8, 2.0),
    ],
)
def test_checksums_and_a_short_auto_stop_are_used_where_the_firmware_has_them(firmware, slowest_reply, auto_stop):
    line = EmulatedLine(firmware, slowest_reply)
    link = RosArduinoBridge(line, SETUP)
    for _ in range(2):  # it may still be in use with checksums
        link.connect(0.02)
        link.write_speeds(40, 40)
        assert link.auto_stop == auto_stop
        line.controller.advance(line.controller.time + 0.5 * min(auto_stop, 2.0))
        assert line.controller.wheel_speeds[0] > 1.0
        line.controller.advance(line.controller.time + 0.5 * min(auto_stop, 2.0) + 0.01)
        assert line.controller._firmware.pwm == (0, 0)
        link.stop()


def test_one_damaged_probe_does_not_give_up_the_checksums():
    line = EmulatedLine('motor_controller')
    line.damage = {with_checksum(b'b') + b'\r': [b'b*00\r']}
    link = RosArduinoBridge(line, SETUP)
    link.connect(0.02)
    assert 'with checksums' in link.name


def test_a_reply_whose_checksum_is_wrong_is_refused():
    link = RosArduinoBridge(line := EmulatedLine('motor_controller'), SETUP)
    link.connect(0.02)
    for reply in (b'12 13\r\n', b'12 13*00\r\n', with_checksum(b'12 13')[:-1] + b'\r\n', b'*\r\n'):
        line.replies = [reply]
        with pytest.raises(BadReplyError, match='instead of a line with a valid checksum'):
            link.read_counts()
    assert link.read_counts() == WheelCounts(0, 0)


def test_a_plain_command_that_lost_its_checksum_moves_nothing():
    link = RosArduinoBridge(line := EmulatedLine('motor_controller'), SETUP)
    link.connect(0.02)
    assert line.controller.receive(b'm 10 10\r').startswith(b'Invalid Command*')
    assert line.controller.receive(b'm 0 0\r').startswith(b'OK*')
    assert line.controller.receive(b'b\rm 10 10\r') == b'57600\r\nOK\r\n'


def test_the_checksum_finds_every_burst_of_8_bits():
    line = int.from_bytes(with_checksum(b'm -120 30'), 'big')
    for pattern in range(1, 256, 2):
        for shift in range(0, 72, 3):
            damaged = (line ^ pattern << shift).to_bytes(12, 'big')
            assert without_checksum(damaged) is None
