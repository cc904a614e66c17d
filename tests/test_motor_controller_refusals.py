"""Serial commands that the motor controller firmware rejects without effect on the motors."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from simulated_motor_controller import SimulatedMotorController

pytestmark = pytest.mark.newest_set_only

INVALID = b'Invalid Command\r\n'
ORDER, PWM = 'o 100 -50', (100, -50)
# The same grammar a second time: letter, numbers, and what each may be.
GRAMMAR = re.compile(r'[ber]|m(?P<m>(?: -?\d{1,5}){2})|o(?P<o>(?: -?\d{1,5}){2})|u (?P<u>-?\d{1,5}(?::-?\d{1,5}){3})')

REFUSED = {
    'no numbers': ['m nan nan', 'm inf 0', 'm 1e3 1', 'm 1.0 1', 'm 0x10 1', 'm +10 10', 'm - 1', 'm --1 1'],
    'signs elsewhere': ['m 1- 1', 'm 1 1-', 'm -', 'm - -'],
    'numbers too large': ['m 1001 0', 'm 0 -1001', 'm 32768 0', 'm 0 -32769', 'm 65546 0', 'm 4294967297 1'],
    'PWM too large': ['o 256 0', 'o 0 -256', 'o 65536 0', 'o 32768 32768'],
    'numbers too long': ['m 000010 10', 'm 10 ' + '0' * 12 + '1', 'm 99999999999 1'],
    'another count of numbers': ['m', 'm ', 'm 10', 'm 10 ', 'm 10 10 10', 'o 10', 'o', 'e 1', 'r 1', 'b 1'],
    'other separators': ['m  10 10', 'm 10  10', 'm 10 10 ', ' m 10 10', 'm,10,10', 'm 10,10', 'm\t1 1', 'm1 1'],
    'gains': ['u 20:12:0', 'u 20:12:0:0', 'u -1:12:0:50', 'u 20:12:0:50:1', 'u 20 12 0 50', 'u 10001:0:0:1'],
    'gains with holes': ['u 20::0:50', 'u :12:0:50', 'u 20:12:0:', 'u nan:1:1:1', 'u 1e3:12:0:50', 'u'],
    'no commands': ['', 'M 1 1', 'z', '?', 'ee', 'bb', 'n 10 10'],
    'what needs a library': ['s 0 90', 't 0', 'p 7', 'x 3 10'],
    "pins that are not the host's": ['d 9', 'c 9 1', 'w 9 1', 'w 12 0', 'c 2 1', 'c 0 0', 'd 18', 'd 33', 'a 4', 'a 8'],
    'what a pin cannot be': ['w 4 2', 'c 4 2', 'c 4', 'd 4 1', 'a -1', 'd -1'],
    'a lost carriage return': ['m 1m 10 10', 'm 10 1m 10 10', 'em 10 10', 'o 10 10o 0 0', 'rm 5 5', 'm 10 10e'],
    'lines too long': ['m ' + '1' * 60, 'm 10 10' + ' ' * 30, 'm 1 1' * 100, 'u 10000:10000:10000:100000'],
    'strange bytes': ['m 10 10\x00', 'm 1\x000 10', '\xff', 'm 10 10\x7f', 'm 10\n10', 'm 10 10\n', 'm\n 10 10'],
}  # fmt: skip


@pytest.fixture(scope='module')
def powered(motor_firmware: Path) -> Iterator[SimulatedMotorController]:
    with SimulatedMotorController(motor_firmware) as controller:
        yield controller


@pytest.fixture
def driving(powered: SimulatedMotorController) -> SimulatedMotorController:
    """A controller whose motors run with a raw PWM."""
    assert powered.ask(ORDER) == 'OK'
    assert powered.truth().pwm == PWM
    return powered


def is_good(line: str) -> bool:
    match = GRAMMAR.fullmatch(line)
    if match is None:
        return False
    for name, limit in (('m', 1000), ('o', 255)):
        if match[name]:
            return all(abs(int(word)) <= limit for word in match[name].split())
    if match['u']:
        *gains, divisor = (int(word) for word in match['u'].split(':'))
        return all(0 <= gain <= 10000 for gain in gains) and 1 <= divisor <= 10000
    return True


@pytest.mark.parametrize('kind', REFUSED)
def test_bad_line_is_refused_and_changes_nothing(driving: SimulatedMotorController, kind: str) -> None:
    for line in REFUSED[kind]:
        before = driving.counts()
        driving.send(line.encode('latin-1') + b'\r')
        answer = driving.run(0.005 + 2e-4 * len(line))
        assert answer == INVALID, line
        assert driving.truth().pwm == PWM, line
        assert driving.counts()[0] >= before[0], line
        assert driving.ask(ORDER) == 'OK'


def test_line_after_a_refused_one_is_obeyed(driving: SimulatedMotorController) -> None:
    for line in ('m nan nan', 'm 1 1' * 100, 'm 1m 10 10', '\x00', ''):
        driving.send(line.encode() + b'\ro 20 30\r')
        answer = driving.run(0.01 + 2e-4 * len(line))
        assert answer == INVALID + b'OK\r\n'
        assert driving.truth().pwm == (20, 30)
        assert driving.ask(ORDER) == 'OK'


def test_carriage_return_in_front_cures_a_lost_one_and_line_feeds_are_forgiven(driving) -> None:
    driving.send(b'm 1')
    driving.run(0.1)
    driving.send(b'\ro 40 50\r')
    assert driving.run(0.01) == INVALID + b'OK\r\n'
    assert driving.truth().pwm == (40, 50)
    driving.send(b'\no 20 30\r\n\n\ne\r\nb\r\n')
    ok, counts, baud = driving.run(0.02).split(b'\r\n')[:3]
    assert ok == b'OK'
    assert re.fullmatch(rb'-?\d+ -?\d+', counts)
    assert baud == b'57600'
    assert driving.truth().pwm == (20, 30)


def test_damaged_lines_are_obeyed_only_if_they_are_commands(driving: SimulatedMotorController) -> None:
    rng = np.random.default_rng(5)
    good = ['m 10 -10', 'o 100 -50', 'u 20:12:0:50', 'e', 'm -1000 1000', 'o 255 255', 'u 1:2:3:4']
    characters = '0123456789-+ :.emnoru\x00\n\x80'
    verdicts = []
    for _ in range(250):
        line = list(str(rng.choice(good)))
        for _ in range(rng.integers(1, 4)):
            at = int(rng.integers(len(line) + 1))
            line[at : at + int(rng.integers(2))] = rng.choice(list(characters), rng.integers(2)).tolist()
        text = ''.join(line)
        driving.send(text.encode('latin-1') + b'\r')
        answer = driving.run(0.012)
        expected = is_good(text.lstrip('\n'))
        assert (answer != INVALID) == expected, text
        if not expected:
            assert driving.truth().pwm == PWM, text
        verdicts.append(expected)
        assert driving.ask('u 20:12:0:50') == 'OK'
        assert driving.ask(ORDER) == 'OK'
    assert 30 < sum(verdicts) < 200


def test_more_lines_than_fit_move_nothing(driving: SimulatedMotorController) -> None:
    assert driving.ask('o 0 0') == 'OK'
    driving.send(b'o 0 0\r' * 100 + b'\r' * 200 + b'e\r' * 200)
    answers = set()
    for _ in range(40):
        answers |= set(driving.run(0.05).split(b'\r\n'))
        assert driving.truth().pwm == (0, 0)
    assert b'OK' in answers
    # What found no room was perhaps the end of a line.
    driving.ask('')
    assert driving.ask('b') == '57600'


def test_every_byte_alone_is_harmless(driving: SimulatedMotorController) -> None:
    for byte in set(range(256)) - set(b'\r\nber'):
        driving.send(bytes([byte]) + b'\r')
        assert driving.run(0.004) == INVALID
    assert driving.truth().pwm == PWM
