"""Diagnostics of the node."""

from dataclasses import replace

from receptions import ACCEPTED, KEY, LAMPS, MOVED, REFUSED, Memory, a_lamp, with_fix, without_fix

from shirube_ros.diagnostics import Level, Status
from vlc_beacon.core.authorization.command_authorizer import CommandAuthorizer, Rejected, RejectionReason
from vlc_beacon.core.receiver.light_receiver import SkipReason
from vlc_beacon.core.settings import AuthorizationSettings
from vlc_beacon.node_output import ReceiverDiagnostics


class Report(ReceiverDiagnostics):
    """The report of a receiver whose counters are lost, at any time."""

    def __init__(self, key=None) -> None:
        self.now = 0.0
        authorizer = CommandAuthorizer(key, Memory('counter file is missing'), {}, AuthorizationSettings())
        super().__init__('hall.yaml', authorizer, lambda: self.now)

    def after(self, output) -> Status:
        """Return the status after an output."""
        self.add(output, 0.01)
        return self.status()


def test_missing_images_and_no_fix_are_reported() -> None:
    report = Report()
    assert (report.status().level, report.status().message[:12]) == (Level.WARN, 'no image yet')
    status = report.after(with_fix())
    assert (status.level, status.message) == (Level.OK, 'fix')
    status = report.after(without_fix())
    assert status.message == 'no fix: no known lamp in view'
    assert status.values['detail'] == 'nothing there'


def test_moved_and_strange_lamps_are_named() -> None:
    status = Report().after(with_fix(lamps=LAMPS, anomalies=(MOVED,)))
    assert status.level is Level.WARN
    assert 'lamp 1 moved' in status.message
    assert 'ID 9, which is not in the beacons file' in status.message


def test_lamps_that_are_left_alone_are_counted_by_the_reason() -> None:
    reasons = (*SkipReason, SkipReason.NO_CODE)
    lamps = [replace(a_lamp(i), skip_reason=reason) for i, reason in enumerate(reasons)]
    values = Report().after(with_fix(lamps=lamps)).values
    assert (values['lamps without a code'], values['lamps too small to be decoded']) == ('2', '1')


def test_messages_are_reported_until_they_change() -> None:
    report, door = Report(), r"'Door 3\nis shut'"
    for message, shown in (('Door 3\nis shut', door), (None, door), (b'\x00\xff', '00ff')):
        status = report.after(with_fix(lamps=[replace(a_lamp(2, beacon=2), message=message)]))
        assert status.values['lamp 2 message'] == shown


def test_commands_are_counted_and_suspicious_ones_raise_an_alarm_for_a_minute() -> None:
    assert 'counter file is missing' in Report(KEY).after(with_fix()).message
    report = Report()
    status = report.after(with_fix([ACCEPTED, REFUSED]))
    assert status.values['commands accepted'] == '1'
    assert 'wrong authentication code' in status.message
    report.now = 61.0
    assert report.after(with_fix()).message == 'fix'


def test_only_unidentified_senders_raise_no_alarm() -> None:
    report, message = Report(), 'command of beacon 1 was sent by a lamp with an unconfirmed ID'
    early = Rejected(RejectionReason.WRONG_BEACON, message)
    for changed, alarm in (
        ({'sender': None, 'outcome': early}, 'fix'),
        ({'sender': 2, 'outcome': early}, 'command of beacon 1'),
        ({'sender': None}, 'wrong authentication code'),
    ):
        message = report.after(with_fix([replace(REFUSED, **changed)])).message
        assert message.startswith(alarm) if alarm == 'fix' else alarm in message
