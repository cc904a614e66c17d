"""Hand-made receiver outputs."""

import numpy as np

from shirube_core.geometry import SE2
from vlc_beacon.core.authorization.command_authorizer import Accepted, Rejected, RejectionReason
from vlc_beacon.core.authorization.keys_and_counters import CommandKey, Counters
from vlc_beacon.core.lamp_image.lamp_tracker import LampSample
from vlc_beacon.core.packet.command_packet import Command, Operation
from vlc_beacon.core.pose.pose_fix import AnomalyKind, BeaconAnomaly, BeaconFix, NoBeaconFix, NoFixReason
from vlc_beacon.core.receiver.beacon_receiver import ReceiverOutput
from vlc_beacon.core.receiver.command_processor import CommandDecision
from vlc_beacon.core.receiver.light_receiver import LampObservation
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

POSE = SE2(1.25, -0.5, 0.75)
KEY = CommandKey(bytes(range(32)))
COMMAND = Command(1, Operation.SLOW, 0.125, 7)
PACKET = KEY.sign(COMMAND)
ACCEPTED = CommandDecision(PACKET, 1, Accepted(COMMAND))
BAD_MAC = Rejected(RejectionReason.BAD_MAC, 'command of beacon 1 has a wrong authentication code')
WRONG_LOCATION = Rejected(RejectionReason.WRONG_LOCATION, 'command of beacon 1 3.0 m from its place')
REFUSED, TOO_FAR = (CommandDecision(PACKET, 1, outcome) for outcome in (BAD_MAC, WRONG_LOCATION))


class Memory:
    """Counters that outlive an authorizer; raises its error if there is one."""

    def __init__(self, error=''):
        self.counters, self.writes, self.error = Counters(), 0, error

    def read(self):
        if self.error:
            raise VlcBeaconError(self.error)
        return self.counters

    def write(self, counters):
        self.read()
        self.counters, self.writes = counters, self.writes + 1


def a_lamp(key, beacon=None, unknown_id=None):
    """Return a lamp at a place of its own."""
    sample = LampSample(key, np.array([40.0 * key, 50.0]), np.full(2, 0.1), 6.0, np.ones(2), None, 0)
    return LampObservation(sample, beacon, unknown_id, ())


LAMPS = (a_lamp(1, beacon=1), a_lamp(2, unknown_id=9), a_lamp(3))


def with_fix(decisions=(), lamps=LAMPS[:1], anomalies=()):
    """Return a reception with a pose."""
    covariance = np.diag([1e-6, 4e-6, 9e-6, 1e-4])
    fix = BeaconFix(POSE, 0.0, covariance, (0.0, 0.0), np.ones(1, bool), np.zeros((1, 2)), anomalies)
    return ReceiverOutput(tuple(lamps), fix, tuple(decisions))


def without_fix(lamps=()):
    """Return a reception without a pose."""
    return ReceiverOutput(tuple(lamps), NoBeaconFix(NoFixReason.NO_LAMP, 'nothing there'), ())


MOVED = BeaconAnomaly(1, 0, AnomalyKind.MOVED)
