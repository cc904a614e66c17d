"""Diagnostics of the node."""

from __future__ import annotations

from dataclasses import replace

from receptions import ACCEPTED, LAMPS, MOVED, REFUSED, a_lamp, with_fix, without_fix

from shirube_ros.diagnostics import Level
from vlc_beacon.core.authorization.command_authorizer import CommandAuthorizer
from vlc_beacon.core.authorization.command_key import CommandKey
from vlc_beacon.core.authorization.decision import Rejected, RejectionReason
from vlc_beacon.core.receiver.tracked_lamp import SkipReason
from vlc_beacon.core.settings import AuthorizationSettings
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError
from vlc_beacon.receiver_diagnostics import ReceiverDiagnostics


class LostCounters:
    def read(self) -> None:
        raise VlcBeaconError('counter file is missing')

    def write(self, _: object) -> None:
        raise AssertionError


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def report(key: CommandKey | None = None) -> tuple[ReceiverDiagnostics, Clock]:
    authorizer, clock = CommandAuthorizer(key, LostCounters(), {}, AuthorizationSettings()), Clock()  # type: ignore[arg-type]
    return ReceiverDiagnostics('hall.yaml', authorizer, clock), clock


def test_missing_images_are_reported() -> None:
    status, clock = report()
    assert (status.status().level, status.status().message[:12]) == (Level.WARN, 'no image yet')
    status.add(with_fix(), 0.01)
    assert (status.status().level, status.status().message) == (Level.OK, 'fix')
    clock.now = 3.0
    assert status.status().message.startswith('images have stopped')


def test_moved_and_strange_lamps_are_named() -> None:
    status, _ = report()
    status.add(with_fix(lamps=LAMPS, anomalies=(MOVED,)), 0.01)
    assert status.status().level is Level.WARN
    assert 'lamp 1 moved' in status.status().message
    assert 'ID 9, which is not in the beacons file' in status.status().message


def test_lamps_that_are_left_alone_are_counted_by_the_reason() -> None:
    status, _ = report()
    lamps = [
        replace(a_lamp(i), skip_reason=skip_reason)
        for i, skip_reason in enumerate((*SkipReason, SkipReason.NO_CODE))
    ]
    status.add(with_fix(lamps=lamps), 0.01)
    values = status.status().values
    assert (values['lamps without a code'], values['lamps too small to be decoded']) == ('2', '1')


def test_messages_are_reported_until_they_change() -> None:
    status, _ = report()
    for message in ('Door 3\nis shut', None, b'\x00\xff'):
        status.add(with_fix(lamps=[replace(a_lamp(2, beacon=2), message=message)]), 0.01)
        if message is None:
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


def test_lost_counters_are_reported_permanently() -> None:
    status, _ = report(CommandKey(bytes(16)))
    status.add(with_fix(), 0.01)
    assert 'counter file is missing' in status.status().message


def test_only_unidentified_senders_raise_no_alarm() -> None:
    status, _ = report()
    early = Rejected(
        RejectionReason.WRONG_BEACON, 'command of beacon 1 was sent by a lamp with an unconfirmed ID'
    )
    status.add(with_fix([replace(REFUSED, sender=None, outcome=early)]), 0.01)
    assert status.status().message == 'fix'
    status.add(with_fix([replace(REFUSED, sender=2, outcome=early)]), 0.01)
    assert 'command of beacon 1' in status.status().message
    status.add(with_fix([replace(REFUSED, sender=None)]), 0.01)
    assert 'wrong authentication code' in status.status().message
