"""Requests and replies of the protocol."""

import re

import numpy as np
import pytest

from motor_bridge.core.controller_protocol import BadReplyError, WheelCounts
from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.core.ros_arduino_bridge import (
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
