"""Diagnostics of the node."""

from __future__ import annotations

from dataclasses import replace

from receptions import ACCEPTED, LAMPS, MOVED, REFUSED, a_lamp, with_fix, without_fix

from shirube_ros.diagnostics import Level
from vlc_beacon.core.receiver.followed_lamp import Silence
from vlc_beacon.core.trust.command_judge import CommandJudge
from vlc_beacon.core.trust.command_key import CommandKey
from vlc_beacon.core.trust.trust_settings import TrustSettings
from vlc_beacon.core.trust.verdict import Refusal, Refused
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError
from vlc_beacon.receiver_report import ReceiverReport


class LostCounters:
    def read(self) -> None:
        raise VlcBeaconError('counter file is missing')

    def write(self, _: object) -> None:
        raise AssertionError


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def report(key: CommandKey | None = None) -> tuple[ReceiverReport, Clock]:
    authorizer, clock = CommandJudge(key, LostCounters(), {}, TrustSettings()), Clock()  # type: ignore[arg-type]
    return ReceiverReport('hall.yaml', authorizer, clock), clock


def test_silence_is_told_before_and_after_images() -> None:
    status, clock = report()
    assert (status.status().level, status.status().message[:12]) == (Level.WARN, 'no image yet')
    status.add(with_fix(), 0.01)
    assert (status.status().level, status.status().message) == (Level.OK, 'fix')
    clock.now = 3.0
    assert status.status().message.startswith('images have stopped')


def test_moved_and_strange_lamps_are_named() -> None:
    status, _ = report()
    status.add(with_fix(lamps=LAMPS, doubts=(MOVED,)), 0.01)
    assert status.status().level is Level.WARN
    assert 'lamp 1 moved' in status.status().message
    assert 'ID 9, which is not in the beacons file' in status.status().message


def test_lamps_that_are_left_alone_are_counted_by_the_reason() -> None:
    status, _ = report()
    lamps = [replace(a_lamp(i), silence=silence) for i, silence in enumerate((*Silence, Silence.NO_CODE))]
    status.add(with_fix(lamps=lamps), 0.01)
    values = status.status().values
    assert (values['lamps without a code'], values['lamps too small to be decoded']) == ('2', '1')


def test_what_lamps_say_is_told_until_they_say_something_else() -> None:
    status, _ = report()
    for said in ('Door 3\nis shut', None, b'\x00\xff'):
        status.add(with_fix(lamps=[replace(a_lamp(2, beacon=2), said=said)]), 0.01)
        if said is None:
            assert status.status().values['lamp 2 message'] == r"'Door 3\nis shut'"
    assert status.status().values['lamp 2 message'] == '00ff'


def test_no_fix_has_its_reason_and_detail() -> None:
    status, _ = report()
    status.add(without_fix(), 0.01)
    assert status.status().message == 'no fix: no known lamp in view'
    assert status.status().values['detail'] == 'nothing there'


def test_commands_are_counted_and_suspicious_ones_raise_an_alarm_for_a_minute() -> None:
    status, clock = report()
    status.add(with_fix([ACCEPTED, REFUSED]), 0.01)
    assert status.status().values['commands accepted'] == '1'
    assert 'wrong authentication code' in status.status().message
    clock.now = 61.0
    status.add(with_fix(), 0.01)
    assert status.status().message == 'fix'


def test_lost_counters_are_told_all_the_time() -> None:
    status, _ = report(CommandKey(bytes(16)))
    status.add(with_fix(), 0.01)
    assert 'counter file is missing' in status.status().message


def test_only_a_lamp_without_a_name_that_speaks_for_a_beacon_raises_no_alarm() -> None:
    status, _ = report()
    early = Refused(Refusal.OTHER_BEACON, 'command of beacon 1 was sent by a lamp with an unconfirmed ID')
    status.add(with_fix([replace(REFUSED, speaker=None, answer=early)]), 0.01)
    assert status.status().message == 'fix'
    status.add(with_fix([replace(REFUSED, speaker=2, answer=early)]), 0.01)
    assert 'command of beacon 1' in status.status().message


def test_wrong_codes_of_a_lamp_without_a_name_raise_an_alarm() -> None:
    status, _ = report()
    status.add(with_fix([replace(REFUSED, speaker=None)]), 0.01)
    assert 'wrong authentication code' in status.status().message
