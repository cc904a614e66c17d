"""``calibrate``: wheel radius and separation from measured runs, written to the robot's parameter file."""

import argparse
import math
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path

from motor_bridge.core.calibration import MeasuredRun, WheelCalibration, calibrate_wheels
from motor_bridge.core.controller_protocol import ControllerProtocol, ControllerSetup, LinkError
from motor_bridge.core.diff_drive_kinematics import DiffDriveKinematics, DriveSettings
from motor_bridge.core.encoder_monitor import count_difference
from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.core.ros_arduino_bridge import RosArduinoBridge
from motor_bridge.link.controller_session import LATENCIES, longer_latency
from motor_bridge.link.serial_port import SerialPort
from motor_bridge.node_settings import NodeSettings
from shirube_core.command import run_command
from shirube_core.files import YamlFileError, read_yaml, write_text
from shirube_core.settings import SettingsError, settings_from_values

_HANDSHAKE_ATTEMPTS = 20  # an Arduino boots for up to 2 s
_DEFAULTS = NodeSettings()
_SECTION = re.compile(r'(?m)^(?P<name>/?(\*\*/)?motor_bridge|/\*\*):.*(?:\n[ \t#].*|\n)*')


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 if a measurement, a file or the port is invalid."""
    options = make_parser().parse_args(arguments)
    try:
        return run_command('calibrate', lambda: calibrate_and_write(options), (MotorBridgeError,))
    except (EOFError, KeyboardInterrupt):
        print('calibrate: aborted before the last measurement; nothing is written', file=sys.stderr)
        return 1


def calibrate_and_write(options: argparse.Namespace) -> None:
    """Calibrate, and write and print the result."""
    calibration = calibrate(options, input)
    out = options.out or options.params
    write_values(options.params, out, {'wheel_radius': calibration.radius, 'wheel_separation': calibration.separation})
    print(_format_calibration(calibration))
    print(f'written to {out}')


def calibrate(options: argparse.Namespace, ask: Callable[[str], str]) -> WheelCalibration:
    """Calibrate from runs that are given as options or measured now; ``ask`` prompts the operator.

    Raises:
        MotorBridgeError: invalid measurements, an invalid file, or a port without a controller.
    """
    settings = read_drive_settings(options.params)
    if options.port is not None:
        if options.straight or options.turn:
            raise MotorBridgeError('--port measures new runs; omit --straight and --turn, or --port')
        return calibrate_wheels(*_measure_runs(options, ask), settings.ticks_per_revolution)
    kinematics = DiffDriveKinematics(settings)
    straights, turns = [], []
    for odometry, measured in options.straight:
        ticks = odometry / kinematics.metres_per_tick
        straights.append(MeasuredRun(ticks, ticks, measured))
    for odometry, measured in options.turn:
        ticks = 0.5 * math.radians(odometry) * kinematics.separation / kinematics.metres_per_tick
        turns.append(MeasuredRun(-ticks, ticks, math.radians(measured)))
    return calibrate_wheels(straights, turns, settings.ticks_per_revolution)


def _measure_runs(
    options: argparse.Namespace, ask: Callable[[str], str]
) -> tuple[list[MeasuredRun], list[MeasuredRun]]:
    """Measure runs while an operator pushes the robot."""
    with SerialPort(options.port, options.baud, _DEFAULTS.reply_timeout) as line:
        link = RosArduinoBridge(line, ControllerSetup(options.baud, _DEFAULTS.gains))
        _handshake(link)
        straights, turns = (
            [_measure_push(link, ask, instruction, question) for _ in range(options.runs)]
            for instruction, question in (
                ('Push the robot straight ahead, 2 m or more, without slip.', 'How far [m]? '),
                ('Turn it on the spot counterclockwise, 5 times or more.', 'How far [degrees]? '),
            )
        )
    return straights, [MeasuredRun(run.left, run.right, math.radians(run.measured)) for run in turns]


def _handshake(link: ControllerProtocol) -> None:
    latency = LATENCIES[0]
    for left in reversed(range(_HANDSHAKE_ATTEMPTS)):
        try:
            link.connect(latency)
        except LinkError:
            if left == 0:
                raise
            latency = longer_latency(latency)
        else:
            return


def _measure_push(link: ControllerProtocol, ask: Callable[[str], str], instruction: str, question: str) -> MeasuredRun:
    ask(f'{instruction} Press Enter before you begin. ')
    before = link.read_counts()
    answer = ask(question)
    left, right = count_difference(before, link.read_counts())
    try:
        measured = float(answer)
    except ValueError as fault:
        raise MotorBridgeError(f'{answer!r} is not a number; measure and type one') from fault
    return MeasuredRun(left, right, measured)


def _format_calibration(calibration: WheelCalibration) -> str:
    radius_spread, separation_spread = 1e3 * calibration.radius_spread, 1e3 * calibration.separation_spread
    lines = [
        f'wheel_radius      {calibration.radius:.5f} m, single straights within {radius_spread:.2f} mm',
        f'wheel_separation  {calibration.separation:.4f} m, single turns within {separation_spread:.1f} mm',
    ]
    if abs(calibration.wheel_asymmetry) > 0.01:
        lines.append(
            f'on straights the left wheel counts {100.0 * calibration.wheel_asymmetry:+.1f} % more than the right one: '
            'check that the runs were straight and the wheels are equal'
        )
    return '\n'.join(lines)


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    parser = argparse.ArgumentParser(
        prog='calibrate',
        description='Calibrate wheel_radius and wheel_separation. Either drive with the node and give the distances of '
        'odometry and of a tape measure, or give --port (stop the node first) and push the robot when asked.',
    )
    add = parser.add_argument
    add('--params', type=Path, required=True, metavar='FILE', help="the robot's parameter file")
    for name, meaning in (('--straight', 'a straight [m]'), ('--turn', 'turns on the spot [degrees]')):
        add(
            name,
            nargs=2,
            type=float,
            action='append',
            default=[],
            metavar=('ODOMETRY', 'MEASURED'),
            help=f'{meaning}; may be repeated',
        )
    add('--port', metavar='DEVICE', help='serial port: read the encoders while the robot is pushed')
    add('--baud', type=int, default=_DEFAULTS.baud, help='baud rate of that port (default: %(default)s)')
    add('--runs', type=int, default=2, help='number of straights and of turns to push (default: %(default)s)')
    add('--out', type=Path, metavar='FILE', help='output file (default: the parameter file)')
    return parser


def read_drive_settings(path: Path) -> DriveSettings:
    """Read the drive settings from a parameter file.

    Raises:
        MotorBridgeError: it is missing or corrupted, or has invalid values.
    """
    try:
        content, section = read_yaml(path), _SECTION.search(path.read_text(encoding='utf-8'))
        node = content.get(section['name']) if section else None
        parameters = node.get('ros__parameters') if isinstance(node, dict) else None
        if not isinstance(parameters, dict):
            raise MotorBridgeError(
                f'{path}: has no /**: ros__parameters: and none of motor_bridge; start from config/motor_bridge.yaml'
            )
        names = {field.name for field in fields(DriveSettings)}
        return settings_from_values(DriveSettings, {k: v for k, v in parameters.items() if k in names})
    except YamlFileError as fault:
        raise MotorBridgeError(f'{fault}; start from config/motor_bridge.yaml') from fault
    except SettingsError as fault:
        raise MotorBridgeError(f'{path}: {fault}') from fault


def write_values(source: Path, path: Path, values: Mapping[str, float]) -> None:
    """Write a parameter file with some changed values, atomically; comments and everything else stay.

    Raises:
        OSError: the file cannot be written.
        MotorBridgeError: the file does not have one parameter per line.
    """
    text = source.read_text(encoding='utf-8')
    section = _SECTION.search(text)
    if section is None:
        raise MotorBridgeError(f'{source}: has no /**: and no motor_bridge:; start from config/motor_bridge.yaml')
    own = section[0]
    for name, value in values.items():
        own, count = re.subn(rf'(?m)^(\s+{name}:)[^#\n]*?(\s*#.*)?$', rf'\g<1> {value:.6g}\g<2>', own)
        if count == 0:
            own, count = re.subn(
                r'(?m)^(\s+)ros__parameters:[ \t]*$', rf'\g<0>\n\g<1>  {name}: {value:.6g}', own, count=1
            )
        if count == 0:
            raise MotorBridgeError(
                f'{source}: {name} needs its own line; write one parameter per line, as config/motor_bridge.yaml does'
            )
    write_text(path, text[: section.start()] + own + text[section.end() :])


if __name__ == '__main__':
    sys.exit(main())
