import math

import numpy as np
import pytest

from vlc_beacon.core.authorization.plausibility import clamp_speed, find_implausibility
from vlc_beacon.core.packet.command_packet import Command
from vlc_beacon.core.packet.operation import Operation


@pytest.mark.parametrize(
    ('operation', 'value'),
    [
        (Operation.STOP, 0.0),
        (Operation.RESUME, 0.0),
        (Operation.SLOW, 0.1),
        (Operation.SPEED_UP, 0.8),
        (Operation.TURN, -math.pi / 2),
        (Operation.TURN, 6.28),
    ],
)
def test_what_the_paper_asks_for_is_plausible(operation: Operation, value: float) -> None:
    assert find_implausibility(Command(1, operation, value, 1)) is None


@pytest.mark.parametrize(
    ('operation', 'value', 'flaw'),
    [
        (0, 0.0, 'operation 0 is unknown'),
        (31, 0.0, 'operation 31 is unknown'),
        (Operation.STOP, 1.0, 'stop cannot have the value 1'),
        (Operation.SLOW, 0.0, 'slow cannot have the value 0'),
        (Operation.SPEED_UP, -0.5, 'speed_up cannot have the value -0.5'),
        (Operation.TURN, 7.0, 'turn cannot have the value 7'),
    ],
)
def test_what_makes_no_sense_is_named(operation: int, value: float, flaw: str) -> None:
    assert find_implausibility(Command(1, operation, value, 1)) == flaw


def test_no_plausible_speed_exceeds_the_limit() -> None:
    rng = np.random.default_rng(0)
    for _ in range(2000):
        limit = float(rng.uniform(0.0, 2.0))
        command = Command(1, int(rng.integers(32)), float(rng.uniform(-2000.0, 2000.0)), 1)
        if find_implausibility(command) is None:
            bounded = clamp_speed(command, limit)
            if command.operation in (Operation.SLOW, Operation.SPEED_UP):
                assert bounded.value <= limit
            else:
                assert bounded == command
