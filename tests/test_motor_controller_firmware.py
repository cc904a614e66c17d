"""Serial commands of the motor controller firmware."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import serial
from simulated_motor_controller import FRAME_SECONDS, SimulatedMotorController
from simulated_terminal import terminal_of

from motor_bridge.core.controller_protocol import with_checksum, without_checksum

pytestmark = pytest.mark.newest_set_only

STOPPED = (0, 0)
DEFAULT_GAINS = 'u 20:12:0:50'
AUTO_STOP_SECONDS = 2.0
SHORT_AUTO_STOP_SECONDS = 0.2
WATCHDOG_SECONDS = 0.15
TICKS_PER_FRAME_MAX = 1000


@pytest.fixture
def controller(motor_firmware: Path) -> Iterator[SimulatedMotorController]:
    with SimulatedMotorController(motor_firmware) as controller:
        yield controller


def speed_of(controller: SimulatedMotorController, order: str, frames: int = 15) -> tuple[float, float]:
    """Return the mean true speed while an order lasts [ticks a frame]."""
    before = controller.truth()
    controller.drive(order, frames * FRAME_SECONDS)
    after = controller.truth()
    passed = (after.seconds - before.seconds) / FRAME_SECONDS
    left, right = ((b - a) / passed for a, b in zip(before.ticks, after.ticks))
    return left, right


@pytest.mark.parametrize(
    ('request_', 'answer'),
    [
        (b'b\r', rb'57600\r\n'),
        (b'e\r', rb'0 0\r\n'),
        *((request, rb'OK\r\n') for request in (b'r\r', b'm 10 -10\r', b'm -1000 1000\r', b'm 0 -0\r')),
        *((request, rb'OK\r\n') for request in (b'o 255 -255\r', b'c 4 1\r', b'w 4 1\r', b'u 20:12:0:50\r')),
        (b'u 10000:10000:10000:10000\r', rb'OK\r\n'),
        (b'a 0\r', rb'\d{1,4}\r\n'),
        (b'd 4\r', rb'[01]\r\n'),
        (b'\r', rb'Invalid Command\r\n'),
        (b'b\r\nb\r\n', rb'57600\r\n57600\r\n'),
        (b'b\rb\re\r', rb'57600\r\n57600\r\n0 0\r\n'),
        (b'\rb\r', rb'Invalid Command\r\n57600\r\n'),
    ],
)
def test_answers_are_those_of_ros_arduino_bridge(controller, request_: bytes, answer: bytes) -> None:
    controller.send(request_)
    assert re.fullmatch(answer, controller.run(0.02))


def test_motors_are_off_until_the_first_command(controller: SimulatedMotorController) -> None:
    for _ in range(50):
        assert controller.truth().pwm == STOPPED
        controller.run(0.001)
    assert controller.truth().ticks == (0, 0)


@pytest.mark.parametrize('pwm', [(255, -255), (1, 255), (-1, 0), (0, 100), (-255, -128)])
def test_raw_pwm_comes_out_at_the_pins(controller: SimulatedMotorController, pwm: tuple[int, int]) -> None:
    assert controller.ask(f'o {pwm[0]} {pwm[1]}') == 'OK'
    assert controller.truth().pwm == pwm
    assert controller.ask('o 0 0') == 'OK'
    assert controller.truth().pwm == STOPPED


def test_counts_are_the_encoders_ticks(controller: SimulatedMotorController) -> None:
    for order in ('o 255 255', 'o -255 100', 'o -30 -255', 'm 40 -40'):
        controller.drive(order, 0.3)
        before = controller.truth().ticks
        counts = controller.counts()
        after = controller.truth().ticks
        for count, one, other in zip(counts, before, after):
            assert min(one, other) <= count <= max(one, other)
    counts = controller.counts_at_rest()
    assert counts == controller.truth().ticks
    assert min(np.abs(counts)) > 100


def test_no_tick_is_lost_at_the_highest_speed(controller: SimulatedMotorController) -> None:
    highest = TICKS_PER_FRAME_MAX / FRAME_SECONDS
    controller.set_motors(highest, highest, 0.02)
    assert controller.ask('o 255 -255') == 'OK'
    for _ in range(60):
        controller.counts()
    left, right = controller.counts_at_rest()
    assert left > 2000
    assert right < -2000
    assert controller.truth().ticks == (left, right)


@pytest.mark.parametrize('order', ['m 40 0', 'o 0 -100'])
def test_motors_stop_two_seconds_after_the_last_order(controller, order: str) -> None:
    controller.drive('o 10 10', 0.7)
    controller.ask('m 0 0')
    controller.send(order.encode() + b'\r')
    # A speed is held from the end of the first frame on.
    began = controller.until_pwm(is_on=True, within=0.05) - FRAME_SECONDS * (order[0] == 'm')
    controller.run(began + 0.5 - controller.truth().seconds)
    for other in ('e', 'b', 'm 10', DEFAULT_GAINS, 'm 1001 0'):
        controller.ask(other)
    controller.run(began + AUTO_STOP_SECONDS - 0.001 - controller.truth().seconds)
    assert any(controller.truth().pwm)
    ended = controller.until_pwm(is_on=False, within=0.1)
    assert AUTO_STOP_SECONDS - 1e-3 < ended - began < AUTO_STOP_SECONDS + 2e-3
    controller.run(0.2)
    assert controller.truth().pwm == STOPPED


def test_a_shorter_auto_stop_holds_until_the_reset(controller: SimulatedMotorController) -> None:
    assert controller.ask('h 200') == 'OK'
    for refused in ('h 199', 'h 2001', 'h', 'h 200 1', 'h -300'):
        assert controller.ask(refused) == 'Invalid Command'
    assert controller.ask('o 50 50') == 'OK'
    began = controller.until_pwm(is_on=True, within=0.05)
    lasted = controller.until_pwm(is_on=False, within=0.5) - began
    assert lasted == pytest.approx(SHORT_AUTO_STOP_SECONDS, abs=0.01)
    controller.hang()
    controller.run(0.5)
    controller.ask('o 50 50')
    controller.run(0.5)
    assert controller.truth().pwm == (50, 50)


def checked(controller: SimulatedMotorController, request: str) -> str | None:
    reply = without_checksum(controller.ask(with_checksum(request.encode()).decode()).encode())
    return reply and reply.decode()


def test_lines_with_checksums_are_answered_with_checksums_and_end_plain_lines(controller) -> None:
    assert controller.ask('m 10 10') == 'OK'
    assert checked(controller, 'b') == '57600'
    assert checked(controller, 'u 10000:10000:10000:10000') == 'OK'
    controller.set_counts(-(2**31))
    assert checked(controller, 'e') == '-2147483648 -2147483648'
    assert checked(controller, 'm 1001 0') == 'Invalid Command'
    assert checked(controller, 'o 40 50') == 'OK'
    for plain in ('o 60 60', 'm 0 0 ', 'e', 'h 200', 'm 0 1'):
        assert controller.ask(plain) == with_checksum(b'Invalid Command').decode()
        assert controller.truth().pwm == (40, 50)
    assert controller.ask('m 0 0') == with_checksum(b'OK').decode()
    assert controller.truth().pwm == STOPPED
    assert controller.ask('b') == '57600'
    assert controller.ask('o 60 60') == 'OK'


def test_no_damaged_line_with_a_checksum_is_obeyed(controller: SimulatedMotorController) -> None:
    line = with_checksum(b'o 70 80')
    rng, damaged = np.random.default_rng(2), set[bytes]()
    for place in range(len(line)):
        damaged |= {line[:place] + bytes([line[place] ^ (1 << bit)]) + line[place + 1 :] for bit in range(7)}
        damaged |= {line[:place] + line[place + 1 :], line[:place] + line[place:][::-1]}
    assert checked(controller, 'b') == '57600'
    for each in rng.permutation(sorted(d for d in damaged - {line} if b'\r' not in d)):
        assert controller.ask(each.decode('latin-1').lstrip('\n')).startswith('Invalid Command'), each
        assert controller.truth().pwm == STOPPED


def test_reset_of_the_encoders_ends_a_held_speed_but_no_pwm(controller: SimulatedMotorController) -> None:
    controller.drive('m 40 40', 0.3)
    assert controller.ask('r') == 'OK'
    assert controller.truth().pwm == STOPPED
    controller.run(0.1)
    assert controller.truth().pwm == STOPPED
    controller.drive('o 90 80', 0.2)
    before = controller.truth().ticks
    assert controller.ask('r') == 'OK'
    assert controller.truth().pwm == (90, 80)
    counts = controller.counts_at_rest()
    after = controller.truth().ticks
    assert np.subtract(counts, np.subtract(after, before)) == pytest.approx(0, abs=6)


@pytest.mark.parametrize(
    ('full_speed', 'lag', 'targets'), [(3000.0, 0.1, (40, -7)), (1500.0, 0.05, (-20, 30)), (6000.0, 0.2, (3, 100))]
)
def test_speed_is_held_whatever_the_motor(controller, full_speed: float, lag: float, targets) -> None:
    controller.set_motors(full_speed, 0.8 * full_speed, lag)
    order = f'm {targets[0]} {targets[1]}'
    controller.drive(order, 3.0)
    assert speed_of(controller, order, 30) == pytest.approx(targets, rel=0.01, abs=0.1)


def test_wheel_that_was_blocked_does_not_run_away(controller: SimulatedMotorController) -> None:
    assert controller.ask('u 20:50:2:50') == 'OK'
    controller.set_motors(0.0, 0.0, 0.1)
    controller.drive('m 90 -90', 1.0)
    assert controller.truth().pwm == (255, -255)
    controller.set_motors(3000.0, 3000.0, 0.1)
    controller.drive('m 80 -80', 2.0)
    assert speed_of(controller, 'm 80 -80') == pytest.approx((80, -80), abs=1.0)


def test_gains_are_taken(controller: SimulatedMotorController) -> None:
    assert controller.ask('u 0:0:0:50') == 'OK'
    controller.ask('m 30 30')
    controller.run(0.3)
    assert controller.truth().pwm == STOPPED
    controller.set_motors(0.0, 0.0, 0.1)
    assert controller.ask('u 100:0:0:50') == 'OK'
    controller.until_pwm(is_on=True, within=0.05)
    assert controller.truth().pwm == (60, 60)
    assert controller.ask('u 7:0:0:7') == 'OK'
    controller.run(1.1 * FRAME_SECONDS)
    assert controller.truth().pwm == (90, 90)


@pytest.mark.parametrize('wrap', [2**31 - 1, 2**15 - 1])
def test_counts_wrap_round_and_the_speed_does_not_notice(controller, wrap: int) -> None:
    start = wrap - 600
    controller.run(0.01)
    controller.set_counts(start)
    controller.drive('m 20 20', 0.9)
    assert max(controller.counts()) < wrap
    pwm = []
    for _ in range(15):
        controller.drive('m 20 20', FRAME_SECONDS)
        pwm.append(controller.truth().pwm)
    # Not a jump to one end of its range.
    assert np.ptp(pwm, axis=0).max() < 20
    counts = controller.counts_at_rest()
    counted = start + np.array(controller.truth().ticks)
    assert counted.min() > wrap
    assert counts == tuple((counted + 2**31) % 2**32 - 2**31)


def test_hung_controller_stops_its_motors(controller: SimulatedMotorController) -> None:
    for order in ('o 200 -200', 'm 40 40'):
        controller.drive(order, 0.2)
        resets = controller.truth().resets
        controller.hang()
        hung = controller.truth().seconds
        assert controller.until_pwm(is_on=False, within=1.0) - hung < WATCHDOG_SECONDS
        at_reset = controller.truth()
        assert at_reset.resets == resets + 1
        controller.run(1.0)
        after = controller.truth()
        assert after.pwm == STOPPED
        assert after.resets == resets + 1
        assert controller.ask('b') == '57600'
        driven = np.subtract(after.ticks, at_reset.ticks)
        assert np.subtract(controller.counts(), driven) == pytest.approx(0, abs=3)


def test_free_pins_are_the_hosts(controller: SimulatedMotorController) -> None:
    controller.drive('o 50 -50', 0.1)
    for pin in (4, 7, 8, 11, 14, 17):
        assert controller.ask(f'c {pin} 1') == 'OK'
        for level in ('1', '0', '1'):
            assert controller.ask(f'w {pin} {level}') == 'OK'
            assert controller.ask(f'd {pin}') == level
    assert controller.truth().pwm == (50, -50)
    assert controller.counts_at_rest() == controller.truth().ticks


def test_host_uses_a_serial_port(controller: SimulatedMotorController) -> None:
    with terminal_of(controller) as path, serial.Serial(str(path), 57600, timeout=20) as port:
        for request, answer in ((b'\r', b'Invalid Command'), (b'b\r', b'57600'), (b'e\r', b'0 0')):
            port.write(request)
            assert port.readline() == answer + b'\r\n'
