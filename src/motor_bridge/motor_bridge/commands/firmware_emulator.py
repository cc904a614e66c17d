"""``firmware_emulator``: a simulated motor controller and robot on a pseudo-terminal."""

import argparse
import os
import select
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from threading import Event, Lock
from time import sleep
from types import FrameType
from typing import TextIO

import numpy as np

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
from shirube_core.command import add_settings, settings_from
from shirube_core.settings import SettingsError

_POLL_PERIOD = 0.1  # [s]
_CHUNK = 4096


def main(arguments: Sequence[str] | None = None) -> int:
    """Run until SIGINT or SIGTERM; return 0, or 1 if an option is invalid."""
    options = make_parser().parse_args(arguments)
    stop_event = Event()

    def end(_number: int, _frame: FrameType | None) -> None:
        stop_event.set()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)
    try:
        emulate(options, stop_event, sys.stdin)
    except (MotorBridgeError, SettingsError) as fault:
        print(f'firmware_emulator: {fault}', file=sys.stderr)
        return 1
    except OSError as fault:
        print(f'firmware_emulator: {options.link}: {fault.strerror}; choose a writable path', file=sys.stderr)
        return 1
    return 0


def emulate(options: argparse.Namespace, stop_event: Event, commands: TextIO) -> None:
    """Serve a controller until the stop event; inject faults from lines of text such as ``silence 1.5``.

    Raises:
        SettingsError: an invalid option.
        OSError: the symbolic link cannot be created.
    """
    settings = settings_from(options, EmulatorSettings)
    rng, fault_rng = np.random.default_rng(options.seed).spawn(2)
    controller, lock, faults = EmulatedController(settings, rng), Lock(), LineFaults(fault_rng)
    faults.inject(FaultRequest('latency', max(0.0, options.latency)))
    terminal = PseudoTerminal(controller, lock, faults=faults, link=options.link)
    with terminal, RealTimeStepper(controller, lock):
        print(terminal.path, flush=True)
        partial_line: bytes | None = b''
        while not stop_event.is_set():
            if partial_line is None:
                sleep(_POLL_PERIOD)
            else:
                partial_line = _read_fault_commands(commands, partial_line, faults)
        with lock:
            pose = controller.T_world_base
    print(f'final pose: x {pose.x:.3f} m, y {pose.y:.3f} m, yaw {pose.yaw:.3f} rad')


def _read_fault_commands(commands: TextIO, partial_line: bytes, faults: LineFaults) -> bytes | None:
    """Inject the faults of received lines; return the partial last line, None at the end of the input."""
    if commands.closed:
        return None
    # Read past the file's own buffer, which `select` does not see.
    if not select.select([commands], [], [], _POLL_PERIOD)[0]:
        return partial_line
    more = os.read(commands.fileno(), _CHUNK)
    if not more:
        return None
    *lines, partial_line = (partial_line + more).split(b'\n')
    for line in lines:
        try:
            faults.inject(parse_fault_request(line.decode(errors='replace')))
        except MotorBridgeError as fault:
            print(f'firmware_emulator: {fault}', file=sys.stderr, flush=True)
    return partial_line


def _seed(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f'{text!r} is not an integer of 0 or more')
    return int(text)


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    parser = argparse.ArgumentParser(
        prog='firmware_emulator',
        description='A simulated motor controller and robot on a pseudo-terminal, whose path is printed. Lines on '
        f'standard input inject faults: {", ".join(FAULTS)}, followed by seconds or a number (silence 1.5).',
    )
    add = parser.add_argument
    add('--link', type=Path, metavar='PATH', help='symbolic link to the terminal, renewed at each reconnection')
    add('--latency', type=float, default=0.002, metavar='S', help='latency of each reply (default: %(default)s)')
    add('--seed', type=_seed, default=0, help='seed of slip and noise (default: %(default)s)')
    add_settings(parser, EmulatorSettings)
    return parser


if __name__ == '__main__':
    sys.exit(main())
