"""The complete receiver, from rendered images to IDs, pose and commands."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import pytest
from lamp_scenes import BEACONS, CAMERA, MOUNT, PLACES, STRANGE_PLACE, id_packets, receptions, speaking_room
from receptions import Memory

from scene_simulator.imaging.exposure import Shutter
from shirube_core.geometry import CameraMount
from vlc_beacon.core.authorization.command_authorizer import CommandAuthorizer
from vlc_beacon.core.authorization.command_key import CommandKey
from vlc_beacon.core.authorization.decision import Accepted, Rejected, RejectionReason
from vlc_beacon.core.light_code.rs_fsk import rs_fsk_waveform
from vlc_beacon.core.packet.command_packet import Command, Operation
from vlc_beacon.core.pose.pose_fix import NoBeaconFix, NoFixReason
from vlc_beacon.core.receiver.beacon_receiver import BeaconReceiver, ReceiverOutput
from vlc_beacon.core.receiver.command_processor import CommandDecision, CommandProcessor
from vlc_beacon.core.settings import AuthorizationSettings, ReceiverSettings
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

KEY = CommandKey(bytes(range(32)))
RULE = Command(4, Operation.SLOW, 0.125, 7)
AUTHORIZATION = AuthorizationSettings(zone_radius=2.0)


@dataclass
class Received:
    """What a drive brought."""

    errors: list[float] = field(default_factory=list)
    turns: list[float] = field(default_factory=list)
    normalised: list[float] = field(default_factory=list)
    reasons: list[NoFixReason] = field(default_factory=list)
    named: set[tuple[int, int]] = field(default_factory=set)
    decisions: list[CommandDecision] = field(default_factory=list)
    keyless: list[CommandDecision] = field(default_factory=list)
    last: ReceiverOutput | None = None


def authorizer(key: CommandKey | None) -> CommandAuthorizer:
    return CommandAuthorizer(key, Memory(), {b.id: b.xyz[:2] for b in BEACONS}, AUTHORIZATION)


def lamp_at(sample_centre: np.ndarray, frame: object) -> int:
    """Return the index of the lamp that is truly at a place of the image."""
    points = frame.photo.pose.camera_points([*PLACES, STRANGE_PLACE])  # type: ignore[attr-defined]
    return int(np.argmin(np.hypot(*(CAMERA.pixels_from_points(points) - sample_centre).T)))


@pytest.fixture(scope='module')
def striped() -> Received:
    """Five seconds of RS-FSK under a rolling shutter, the fourth lamp with a rule; UFSOOK has the lamp drive's bag."""
    packets = [[packet, packet] for packet in id_packets()]
    packets[3].append(KEY.sign(RULE).to_bytes())
    drive = speaking_room(
        [rs_fsk_waveform(content, 30.0) for content in packets], Shutter(6e-5, 18.9e-6), 30.0
    )
    settings = ReceiverSettings(shutter='rolling', row_time=18.9e-6, exposure_time=6e-5)
    received, receiver = Received(), BeaconReceiver(BEACONS, MOUNT, authorizer(KEY), settings)
    keyless = CommandProcessor(authorizer(None))
    for frame, output in receptions(receiver, drive, 5.0):
        received.last = output
        received.decisions += output.decisions
        received.keyless += keyless.process(frame.stamp, output.lamps)
        for lamp in output.lamps:
            if lamp.beacon is not None:
                received.named.add((lamp.beacon, lamp_at(lamp.sample.centre, frame) + 1))
        found = output.result
        if isinstance(found, NoBeaconFix):
            received.reasons.append(found.reason)
            continue
        received.errors.append(found.T_map_base.distance_to(frame.pose))
        received.turns.append(abs(found.T_map_base.yaw_to(frame.pose)))
        received.normalised.append(
            received.errors[-1] / math.sqrt(found.covariance[0, 0] + found.covariance[1, 1])
        )
    return received


def test_each_lamp_gets_its_own_id_and_the_steady_one_none(striped: Received) -> None:
    assert striped.named == {(i, i) for i in range(1, 5)}
    assert striped.last is not None
    assert sum(lamp.beacon is not None for lamp in striped.last.lamps) == 4


def test_pose_error_matches_its_covariance(striped: Received) -> None:
    assert len(striped.errors) > 20
    assert max(striped.errors) < 0.02
    assert np.median(striped.errors) < 0.008
    assert max(striped.turns) < 0.01
    assert max(striped.normalised) < 3.0
    assert set(striped.reasons) <= {NoFixReason.NO_LAMP, NoFixReason.TOO_FEW_LAMPS}


def test_a_rule_is_accepted_once_a_visit(striped: Received) -> None:
    accepted = [decision for decision in striped.decisions if isinstance(decision.outcome, Accepted)]
    assert [(decision.outcome, decision.sender) for decision in accepted] == [(Accepted(RULE), 4)]
    refused = [decision.outcome for decision in striped.decisions if isinstance(decision.outcome, Rejected)]
    assert all(outcome.reason is RejectionReason.WRONG_BEACON for outcome in refused)


def test_without_a_key_the_rule_is_rejected_and_reported_once(striped: Received) -> None:
    (decision,) = striped.keyless
    assert isinstance(decision.outcome, Rejected)
    assert decision.outcome.reason is RejectionReason.NO_KEY


def test_a_camera_that_looks_down_is_rejected() -> None:
    with pytest.raises(VlcBeaconError, match='does not look up'):
        BeaconReceiver(BEACONS, CameraMount(), authorizer(None))
