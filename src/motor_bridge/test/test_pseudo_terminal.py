"""The emulated controller on a serial port, with injected faults."""

import time
from contextlib import ExitStack
from threading import Lock

import numpy as np
import pytest
import serial

from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.emulator.emulated_controller import EmulatedController
from motor_bridge.emulator.firmware import EmulatorSettings
from motor_bridge.emulator.pseudo_terminal import (
    FAULTS,
    FaultRequest,
    LineFaults,
    PseudoTerminal,
    RealTimeStepper,
    parse_fault_request,
)

pytestmark = pytest.mark.newest_set_only

SETTINGS = EmulatorSettings(encoder_noise=0.0, boot_time=0.1)


class Bench:
    def __init__(self, stack):
        self.controller, self.lock = EmulatedController(SETTINGS, np.random.default_rng(3)), Lock()
        self.faults = LineFaults(np.random.default_rng(4))
        terminal = stack.enter_context(PseudoTerminal(self.controller, self.lock, faults=self.faults))
        self.port = stack.enter_context(serial.Serial(terminal.path, 57600, timeout=0.3))

    def ask(self, request):
        self.port.write(request)
        return self.port.read_until(b'\n')


@pytest.fixture
def bench():
    with ExitStack() as stack:
        yield Bench(stack)


def test_replies_come_over_the_line(bench):
    assert bench.ask(b'b\r') == b'57600\r\n'
    assert bench.ask(b'm 10 10\r') == b'OK\r\n'
    with bench.lock:
        bench.controller.advance(1.0)
    assert int(bench.ask(b'e\r').split()[0]) > 100


def test_in_real_time_the_robot_drives_by_itself(bench):
    bench.ask(b'm 10 10\r')
    with RealTimeStepper(bench.controller, bench.lock):
        time.sleep(0.3)
    assert 0.1 < bench.controller.time < 0.9
    assert bench.controller.T_world_base.x > 0.0


def test_as_many_replies_are_corrupted_as_ordered(bench):
    for kind in ('garbage', 'wrong'):
        bench.faults.inject(FaultRequest(kind, 1))
        spoilt = bench.ask(b'e\r')
        bench.port.reset_input_buffer()
        assert spoilt != b'0 0\r\n'
        assert bench.ask(b'e\r') == b'0 0\r\n'


@pytest.mark.parametrize(('kind', 'amount', 'again'), [('silence', 0.2, b'b\r'), ('lost_cr', 1, b'\r')])
def test_silence_and_a_lost_carriage_return_swallow_one_reply(bench, kind, amount, again):
    bench.faults.inject(FaultRequest(kind, amount))
    assert bench.ask(b'b\r') == b''
    assert bench.ask(again) == b'57600\r\n'


def test_a_controller_that_hangs_answers_later(bench):
    bench.faults.inject(FaultRequest('hang', 0.8))
    time.sleep(0.05)
    assert bench.ask(b'b\r') == b''
    bench.port.timeout = 20.0
    assert bench.ask(b'b\r') == b'57600\r\n'
    assert bench.port.read_until(b'\n') == b'57600\r\n'


@pytest.mark.parametrize(
    ('line', 'words'),
    [
        ('', "unknown fault ''; choose one of silence"),
        ('explode 3', "unknown fault 'explode'"),
        ('silence x', 'silence x: give a number above 0'),
        ('silence -1', 'silence -1: give a number above 0'),
        ('hang nan', 'hang nan: give a number above 0'),
    ],
)
def test_a_bad_order_is_one_line(line, words):
    with pytest.raises(MotorBridgeError, match=words) as refusal:
        parse_fault_request(line)
    assert '\n' not in str(refusal.value)
    assert parse_fault_request('silence 1.5\n') == FaultRequest('silence', 1.5)
    assert [parse_fault_request(kind).amount for kind in FAULTS] == [1.0] * len(FAULTS)
