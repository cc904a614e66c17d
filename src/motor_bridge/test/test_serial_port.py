"""A port that cannot be used is reported in one line."""

import errno
import os
import pty
import threading
import time
import tty
from contextlib import suppress

import pytest
import serial

from motor_bridge.link import serial_port
from motor_bridge.link.serial_port import PortError, SerialPort


@pytest.fixture
def wire():
    master, slave = pty.openpty()
    tty.setraw(slave)
    with SerialPort(os.ttyname(slave), 57600, 0.1) as port:
        yield port, master, slave
    for file in (master, slave):
        with suppress(OSError):
            os.close(file)


def refusal(path):
    with pytest.raises(PortError) as told:
        SerialPort(str(path), 57600, 0.1)
    assert '\n' not in str(told.value)
    assert str(told.value).startswith(str(path))
    return str(told.value)


def test_a_port_that_is_missing_no_terminal_or_taken_is_reported(tmp_path, wire):
    (tmp_path / 'file').touch()
    for path, words in (
        (tmp_path / 'ttyUSB7', 'does not exist; connect the controller or set port'),
        *[(path, 'is not a working serial port') for path in (tmp_path / 'file', tmp_path, '/dev/null')],
        (wire[0]._path, 'is in use by another program; stop it'),
    ):
        assert words in refusal(path)


def test_a_port_that_may_not_be_opened_is_reported(monkeypatch, tmp_path):
    def refuse(*_, **__):
        raise serial.SerialException(errno.EACCES, 'could not open port')

    monkeypatch.setattr(serial_port.serial, 'Serial', refuse)
    assert 'add the user to the group dialout or install the udev rule' in refusal(tmp_path / 'tty')


def test_lines_are_cut_at_their_ends_or_when_too_long_and_silence_ends(wire):
    port, master, _ = wire
    os.write(master, b'12 13\r\nOK\r\nrest')
    assert [port.read_line(64) for _ in range(3)] == [b'12 13\r\n', b'OK\r\n', b'rest']
    os.write(master, b'x' * 100)
    assert port.read_line(64) == b'x' * 64
    port.discard_received()
    start = time.monotonic()
    assert port.read_line(64) == b''
    assert time.monotonic() - start < 2.0


def test_draining_drops_what_comes_late_and_ends_though_the_line_never_does(wire):
    port, master, _ = wire
    begun, over = threading.Event(), threading.Event()

    def talk():
        while not over.wait(0.005):
            os.write(master, b'tick\r\n')
            begun.set()

    talker = threading.Thread(target=talk)
    talker.start()
    try:
        assert begun.wait(10.0)
        assert port.drain() > 0
    finally:
        over.set()
        talker.join()
    port.drain()
    os.write(master, b'OK\r\n')
    assert port.read_line(64) == b'OK\r\n'


def test_a_port_that_is_gone_is_one_line_whatever_is_done(wire):
    port, master, slave = wire
    os.close(master)
    os.close(slave)
    with pytest.raises(PortError, match='was disconnected or accepts no bytes; reconnect the controller'):
        port.read_line(64)
    for do in (lambda: port.write(b'e\r'), port.drain, port.discard_received):
        with suppress(PortError):  # no other exception may be raised
            do()


def test_a_device_that_takes_no_bytes_does_not_hold_us(wire):
    with pytest.raises(PortError, match='accepts no bytes'):
        list(map(wire[0].write, [b'x' * 4096] * 100))
