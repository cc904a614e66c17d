"""Requests and replies of the protocol."""

import re

import numpy as np
import pytest

from motor_bridge.core.controller_link import (
    BadReplyError,
    WheelCounts,
    check_acknowledged,
    gains_request,
    parse_baud,
    parse_counts,
    speeds_request,
)
from motor_bridge.core.motor_bridge_error import MotorBridgeError


def test_commands_are_ended_by_a_carriage_return_alone():
    assert speeds_request(-12, 30) == b'm -12 30\r'
    assert gains_request(20, 12, 0, 50) == b'u 20:12:0:50\r'


@pytest.mark.parametrize('pair', [(32768, 0), (0, -40000)])
def test_speeds_of_more_than_16_bits_are_never_sent(pair):
    with pytest.raises(MotorBridgeError, match='at most 32767'):
        speeds_request(*pair)


@pytest.mark.parametrize(
    ('reply', 'counts'),
    [
        (b'0 0\r\n', WheelCounts(0, 0)),
        (b'-5 17\r\n', WheelCounts(-5, 17)),
        (b'2147483647 -2147483648\r\n', WheelCounts(2**31 - 1, -(2**31))),
    ],
)
def test_counts_are_read(reply, counts):
    assert parse_counts(reply) == counts


@pytest.mark.parametrize(
    'reply',
    [
        *[
            b'',
            b'\r\n',
            b'5\r\n',
            b'5 6\n',
            b'5 6\r',
            b'5 6',
            b' 5 6\r\n',
            b'5  6\r\n',
            b'5 6 \r\n',
            b'5 6 7\r\n',
        ],
        *[b'+5 6\r\n', b'5 --6\r\n', b'5 6\r\n\r\n', b'OK\r\n', b'nan nan\r\n', b'1e3 2\r\n', b'5.0 6\r\n'],
        *[
            b'5\x006\r\n',
            b'\xd9\xa5 \xd9\xa6\r\n',
            b'2147483648 0\r\n',
            b'0 -2147483649\r\n',
            b'99999999999 1\r\n',
        ],
    ],
)
def test_other_replies_are_no_counts(reply):
    with pytest.raises(BadReplyError, match='instead of two counts') as refusal:
        parse_counts(reply)
    assert re.fullmatch(r'[ -~]+', str(refusal.value))


@pytest.mark.parametrize('reply', [b'', b'OK', b'OK\n', b'ok\r\n', b'OKOK\r\n', b'Invalid Command\r\n'])
def test_only_ok_is_done(reply):
    check_acknowledged(b'OK\r\n')
    with pytest.raises(BadReplyError, match='instead of OK'):
        check_acknowledged(reply)


@pytest.mark.parametrize('reply', [b'', b'OK\r\n', b'576\x0000\r\n', b'57600', b'-57600\r\n', b'57600 1\r\n'])
def test_only_a_number_is_a_baud_rate(reply):
    assert parse_baud(b'57600\r\n') == 57600
    with pytest.raises(BadReplyError, match='instead of a baud rate'):
        parse_baud(reply)


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
