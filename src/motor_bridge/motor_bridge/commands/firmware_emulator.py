"""``firmware_emulator``: a motor controller on a pseudo-terminal, with a robot around it."""

from __future__ import annotations

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
from motor_bridge.emulator.emulator_settings import EmulatorSettings
from motor_bridge.emulator.line_faults import FAULTS, LineFaults, read_fault_order
from motor_bridge.emulator.pseudo_terminal import PseudoTerminal
from motor_bridge.emulator.real_time import RealTime
from shirube_settings import SettingsError, describe_settings, settings_from_values

_LOOK = 0.1  # [s]
_CHUNK = 4096


def main(arguments: Sequence[str] | None = None) -> int:
    """Run until SIGINT or SIGTERM; return 0, or 1 when an option is bad."""
    options = make_parser().parse_args(arguments)
    is_over = Event()

    def end(_number: int, _frame: FrameType | None) -> None:
        is_over.set()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)
    try:
        emulate(options, is_over, sys.stdin)
    except (MotorBridgeError, SettingsError) as fault:
        print(f'firmware_emulator: {fault}', file=sys.stderr)
        return 1
    except OSError as fault:
        print(
            f'firmware_emulator: {options.link}: {fault.strerror}; choose a writable place', file=sys.stderr
        )
        return 1
    return 0


def emulate(options: argparse.Namespace, is_over: Event, orders: TextIO) -> None:
    """Serve a controller until all is over; faults come as lines.

    Args:
        options: of the command.
        is_over: ends it.
        orders: lines such as ``silence 1.5``.

    Raises:
        SettingsError: a bad option.
        OSError: the link cannot be made.
    """
    given = {each.name: getattr(options, each.name) for each in describe_settings(EmulatorSettings)}
    settings = settings_from_values(EmulatorSettings, given)
    rng, fault_rng = np.random.default_rng(options.seed).spawn(2)
    controller, lock, faults = EmulatedController(settings, rng), Lock(), LineFaults(fault_rng)
    terminal = PseudoTerminal(controller, lock, faults=faults, latency=options.latency, link=options.link)
    with terminal, RealTime(controller, lock):
        print(terminal.path, flush=True)
        rest: bytes | None = b''
        while not is_over.is_set():
            if rest is None:
                sleep(_LOOK)
            else:
                rest = _take_orders(orders, rest, faults)
        with lock:
            pose = controller.T_world_base
    print(f'the robot stands at x {pose.x:.3f} m, y {pose.y:.3f} m, yaw {pose.yaw:.3f} rad')


def _take_orders(orders: TextIO, rest: bytes, faults: LineFaults) -> bytes | None:
    """Take the orders that came; return the beginning of the next one, None where nobody orders any more."""
    if orders.closed:
        return None
    # Not through the file's own buffer, of which `select` does not know.
    if not select.select([orders], [], [], _LOOK)[0]:
        return rest
    more = os.read(orders.fileno(), _CHUNK)
    if not more:
        return None
    *lines, rest = (rest + more).split(b'\n')
    for line in lines:
        try:
            faults.order(read_fault_order(line.decode(errors='replace')))
        except MotorBridgeError as fault:
            print(f'firmware_emulator: {fault}', file=sys.stderr, flush=True)
    return rest


def _seed(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f'{text!r} is no number from 0 up')
    return int(text)


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    parser = argparse.ArgumentParser(
        prog='firmware_emulator',
        description='A motor controller with a robot on a pseudo-terminal, whose path is printed. Lines on the '
        f'standard input order faults: {", ".join(FAULTS)}, with seconds or a number behind (silence 1.5).',
    )
    add = parser.add_argument
    add(
        '--link',
        type=Path,
        metavar='PATH',
        help='make a link to the terminal there, renewed at each plugging in',
    )
    add('--latency', type=float, default=0.002, metavar='S', help='of each reply (default: %(default)s)')
    add('--seed', type=_seed, default=0, help='of slip and noise (default: %(default)s)')
    for each in describe_settings(EmulatorSettings):
        unit = f' [{each.unit}]' if each.unit else ''
        add(
            f'--{each.name.replace("_", "-")}',
            type=each.type,
            default=each.default,
            help=f'{each.description}{unit} (default: %(default)s)'.replace(' %', ' %%').replace(
                '(default: %%', '(default: %'
            ),
        )
    return parser


if __name__ == '__main__':
    sys.exit(main())
