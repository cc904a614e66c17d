"""Hand-made receiver outputs."""

import numpy as np

from shirube_geometry import PlanarPose
from vlc_beacon.core.lamp_image.lamp_tracks import LampSample
from vlc_beacon.core.packet.command_packet import Command
from vlc_beacon.core.packet.operation import Operation
from vlc_beacon.core.pose.pose_fix import BeaconDoubt, BeaconFix, DoubtKind, NoBeaconFix, NoFixReason
from vlc_beacon.core.receiver.beacon_receiver import Reception
from vlc_beacon.core.receiver.command_hearing import Verdict
from vlc_beacon.core.receiver.light_receiver import ReadLamp
from vlc_beacon.core.trust.command_key import CommandKey
from vlc_beacon.core.trust.verdict import Accepted, Refusal, Refused

POSE = PlanarPose(1.25, -0.5, 0.75)
COMMAND = Command(1, Operation.SLOW, 0.125, 7)
PACKET = CommandKey(bytes(range(32))).sign(COMMAND)
ACCEPTED = Verdict(PACKET, 1, Accepted(COMMAND))
REFUSED = Verdict(PACKET, 1, Refused(Refusal.BAD_MAC, 'command of beacon 1 has a wrong authentication code'))
TOO_FAR = Verdict(PACKET, 1, Refused(Refusal.OTHER_PLACE, 'command of beacon 1 3.0 m from its place'))


def a_lamp(key, beacon=None, stranger=None):
    """Return a lamp at a place of its own."""
    sample = LampSample(key, np.array([40.0 * key, 50.0]), np.full(2, 0.1), 6.0, np.ones(2), None, 0)
    return ReadLamp(sample, beacon, stranger, ())


LAMPS = (a_lamp(1, beacon=1), a_lamp(2, stranger=9), a_lamp(3))


def with_fix(verdicts=(), lamps=LAMPS[:1], doubts=()):
    """Return a reception with a pose."""
    covariance = np.diag([1e-6, 4e-6, 9e-6, 1e-4])
    fix = BeaconFix(POSE, 0.0, covariance, (0.0, 0.0), np.ones(1, bool), np.zeros((1, 2)), doubts)
    return Reception(tuple(lamps), fix, tuple(verdicts))


def without_fix(lamps=()):
    """Return a reception without a pose."""
    return Reception(tuple(lamps), NoBeaconFix(NoFixReason.NO_LAMP, 'nothing there'), ())


MOVED = BeaconDoubt(1, 0, DoubtKind.MOVED)
