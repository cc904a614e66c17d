"""The complete receiver, from rendered images to IDs, pose and commands."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import pytest
from lamp_scenes import BEACONS, CAMERA, MOUNT, PLACES, STRANGE_PLACE, id_packets, receptions, speaking_room

from scene_simulator.shutter import Shutter
from shirube_geometry import CameraMount
from vlc_beacon.core.light_code.rs_fsk import rs_fsk_waveform
from vlc_beacon.core.light_code.ufsook import ufsook_waveform
from vlc_beacon.core.packet.command_packet import Command
from vlc_beacon.core.packet.operation import Operation
from vlc_beacon.core.pose.beacon import Beacon
from vlc_beacon.core.pose.pose_fix import NoBeaconFix, NoFixReason
from vlc_beacon.core.receiver.beacon_receiver import BeaconReceiver, Reception
from vlc_beacon.core.receiver.command_hearing import CommandHearing, Verdict
from vlc_beacon.core.receiver.settings import ReceiverSettings
from vlc_beacon.core.trust.command_judge import CommandJudge
from vlc_beacon.core.trust.command_key import CommandKey
from vlc_beacon.core.trust.counters import Counters
from vlc_beacon.core.trust.trust_settings import TrustSettings
from vlc_beacon.core.trust.verdict import Accepted, Refusal, Refused
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError

KEY = CommandKey(bytes(range(32)))
RULE = Command(4, Operation.SLOW, 0.125, 7)
TRUST = TrustSettings(zone_radius=2.0)


class Memory:
    def __init__(self) -> None:
        self.counters = Counters()

    def read(self) -> Counters:
        return self.counters

    def write(self, counters: Counters) -> None:
        self.counters = counters


@dataclass
class Heard:
    """What a drive brought."""

    errors: list[float] = field(default_factory=list)
    turns: list[float] = field(default_factory=list)
    spreads: list[float] = field(default_factory=list)
    reasons: list[NoFixReason] = field(default_factory=list)
    named: set[tuple[int, int]] = field(default_factory=set)
    verdicts: list[Verdict] = field(default_factory=list)
    keyless: list[Verdict] = field(default_factory=list)
    last: Reception | None = None


def authorizer(key: CommandKey | None) -> CommandJudge:
    return CommandJudge(key, Memory(), {b.id: b.xyz[:2] for b in BEACONS}, TRUST)


def lamp_at(sample_centre: np.ndarray, frame: object) -> int:
    """Return the index of the lamp that is truly at a place of the image."""
    points = frame.photo.pose.camera_points([*PLACES, STRANGE_PLACE])  # type: ignore[attr-defined]
    return int(np.argmin(np.hypot(*(CAMERA.pixels_from_points(points) - sample_centre).T)))


def hear(waveforms: list, shutter: Shutter, rate: float, seconds: float, settings: ReceiverSettings,
         beacons: list[Beacon] = BEACONS) -> Heard:  # fmt: skip
    heard, receiver = Heard(), BeaconReceiver(beacons, MOUNT, authorizer(KEY), settings)
    keyless = CommandHearing(authorizer(None))
    for frame, reception in receptions(receiver, speaking_room(waveforms, shutter, rate), seconds):
        heard.last = reception
        heard.verdicts += reception.verdicts
        heard.keyless += keyless.hear(frame.stamp, reception.lamps)
        for lamp in reception.lamps:
            if lamp.beacon is not None:
                heard.named.add((lamp.beacon, lamp_at(lamp.sample.centre, frame) + 1))
        found = reception.result
        if isinstance(found, NoBeaconFix):
            heard.reasons.append(found.reason)
            continue
        heard.errors.append(found.T_map_base.distance_to(frame.pose))
        heard.turns.append(abs(found.T_map_base.turn_to(frame.pose)))
        heard.spreads.append(heard.errors[-1] / math.sqrt(found.covariance[0, 0] + found.covariance[1, 1]))
    return heard


@pytest.fixture(scope='module')
def blinking() -> Heard:
    """A little of UFSOOK under a global shutter."""
    waveforms = [ufsook_waveform([packet]) for packet in id_packets()]
    return hear(waveforms, Shutter(0.0005), 60.0, 3.0, ReceiverSettings())


@pytest.fixture(scope='module')
def striped() -> Heard:
    """Five seconds of RS-FSK under a rolling shutter, the fourth lamp with a rule."""
    packets = [[packet, packet] for packet in id_packets()]
    packets[3].append(KEY.sign(RULE).to_bytes())
    waveforms = [rs_fsk_waveform(content, 30.0) for content in packets]
    settings = ReceiverSettings(shutter='rolling', row_time=18.9e-6, exposure_time=6e-5)
    return hear(waveforms, Shutter(6e-5, 18.9e-6), 30.0, 5.0, settings)


ALL = {(i, i) for i in range(1, 5)}


@pytest.mark.newest_set_only
def test_each_lamp_gets_its_own_id_and_the_steady_one_none(blinking: Heard, striped: Heard) -> None:
    assert blinking.named == striped.named == ALL
    for heard in (blinking, striped):
        assert heard.last is not None
        assert sum(lamp.beacon is not None for lamp in heard.last.lamps) == 4


@pytest.mark.parametrize('name', ['blinking', 'striped'])
def test_the_pose_is_as_good_as_it_says(name: str, request: pytest.FixtureRequest) -> None:
    heard: Heard = request.getfixturevalue(name)
    assert len(heard.errors) > 20
    assert max(heard.errors) < 0.02
    assert np.median(heard.errors) < 0.008
    assert max(heard.turns) < 0.01
    assert max(heard.spreads) < 3.0
    assert set(heard.reasons) <= {NoFixReason.NO_LAMP, NoFixReason.TOO_FEW_LAMPS}


def test_a_rule_is_accepted_once_a_visit(striped: Heard) -> None:
    accepted = [verdict for verdict in striped.verdicts if isinstance(verdict.answer, Accepted)]
    assert [(verdict.answer, verdict.speaker) for verdict in accepted] == [(Accepted(RULE), 4)]
    refused = [verdict.answer for verdict in striped.verdicts if isinstance(verdict.answer, Refused)]
    assert all(answer.reason is Refusal.OTHER_BEACON for answer in refused)


def test_without_a_key_the_rule_is_refused_and_the_refusal_told_once(striped: Heard) -> None:
    (verdict,) = striped.keyless
    assert isinstance(verdict.answer, Refused)
    assert verdict.answer.reason is Refusal.NO_KEY


def test_a_camera_that_looks_down_is_refused() -> None:
    with pytest.raises(VlcBeaconError, match='does not look up'):
        BeaconReceiver(BEACONS, CameraMount(), authorizer(None))
