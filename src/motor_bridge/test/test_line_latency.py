"""The bridge connects and stays connected over lines with latency, such as Bluetooth."""

from __future__ import annotations

from contextlib import ExitStack
from functools import partial
from threading import Event, Lock
from time import monotonic

import numpy as np
import pytest

from motor_bridge.core.base_drive import BaseDrive
from motor_bridge.core.controller_protocol import ControllerSetup
from motor_bridge.core.diff_drive_kinematics import DiffDriveKinematics
from motor_bridge.core.drive_settings import DriveSettings
from motor_bridge.core.encoder_odometry import EncoderOdometry
from motor_bridge.core.ros_arduino_bridge import RosArduinoBridge
from motor_bridge.emulator.emulated_controller import EmulatedController
from motor_bridge.emulator.emulator_settings import EmulatorSettings
from motor_bridge.emulator.line_faults import FaultRequest, LineFaults
from motor_bridge.emulator.pseudo_terminal import PseudoTerminal
from motor_bridge.link.controller_session import ControllerSession, LinkReport
from motor_bridge.link.serial_port import SerialPort

pytestmark = pytest.mark.newest_set_only


PLAIN, CHECKED = 'ros_arduino_bridge', 'motor_controller'


@pytest.mark.parametrize(
    ('firmware', 'latency', 'jitter'),
    [
        (PLAIN, 0.025, 0.01),
        (PLAIN, 0.06, 0.06),
        (CHECKED, 0.06, 0.06),
        (PLAIN, 0.15, 0.1),
        (CHECKED, 0.25, 0.0),
    ],
)
def test_it_connects_with_latency_and_jitter(firmware: str, latency: float, jitter: float) -> None:
    settings, faults = DriveSettings(), LineFaults(np.random.default_rng(3))
    base = DiffDriveKinematics(settings)
    controller = EmulatedController(
        EmulatorSettings(encoder_noise=0.0, firmware=firmware), np.random.default_rng(1)
    )
    for kind, seconds in (('latency', latency), ('jitter', jitter)):
        faults.inject(FaultRequest(kind, seconds))
    session = ControllerSession(
        BaseDrive(base, settings, 0.033),
        EncoderOdometry(base, settings),
        monotonic,
        LinkReport(lambda *_: None),
        lambda _: None,
    )
    make = partial(RosArduinoBridge, setup=ControllerSetup(57600, (20, 12, 0, 50), 0.25))
    with ExitStack() as stack:
        path = stack.enter_context(PseudoTerminal(controller, Lock(), faults=faults)).path
        link = make(stack.enter_context(SerialPort(path, 57600, 0.2)))
        session.connect(link, Event())  # a PortError after 5 s otherwise
        assert session.step(link, Event(), is_cycle=True)
    assert session.report.faults.total() == 0
    assert ('with checksums' in link.name) == (firmware == CHECKED)
