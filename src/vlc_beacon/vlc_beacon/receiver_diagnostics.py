"""Diagnostics of the node: pose, lamps in view, beacon anomalies and commands."""

from collections import Counter
from collections.abc import Callable
from time import monotonic

from shirube_ros.diagnostics import Level, Status
from vlc_beacon.core.authorization.command_authorizer import CommandAuthorizer
from vlc_beacon.core.authorization.decision import Accepted, RejectionReason
from vlc_beacon.core.pose.pose_fix import BeaconAnomaly, BeaconFix
from vlc_beacon.core.receiver.beacon_receiver import ReceiverOutput

_ALARM_DURATION = 60.0
"""Duration of the warning after a suspicious command [s]."""


class ReceiverDiagnostics:
    """Collects statistics of the receiver output."""

    def __init__(self, beacons_file: str, authorizer: CommandAuthorizer, now: Callable[[], float] = monotonic) -> None:
        """Start without output; the path and the permanent rejection of the authorizer are reported."""
        self._beacons_file = beacons_file
        self._authorizer = authorizer
        self._now = now
        self._latest: ReceiverOutput | None = None
        self._duration = 0.0
        self._fixes = 0
        self._no_fixes: Counter[str] = Counter()
        self._commands: Counter[str] = Counter()
        self._messages: dict[str, str] = {}
        self._alarm, self._alarm_at = '', -float('inf')

    def add(self, output: ReceiverOutput, duration: float) -> None:
        """Add the output of an image with its processing time ``duration`` [s]."""
        self._latest, self._duration = output, duration
        if isinstance(output.result, BeaconFix):
            self._fixes += 1
        else:
            self._no_fixes[output.result.reason.value] += 1
        self._messages |= {message.sender_name: message.printable for message in output.messages}
        for decision in output.decisions:
            outcome = decision.outcome
            if isinstance(outcome, Accepted):
                self._commands['accepted'] += 1
                continue
            self._commands[f'rejected: {outcome.reason.value}'] += 1
            # A genuine lamp may send commands before its ID is confirmed.
            is_unconfirmed = outcome.reason is RejectionReason.WRONG_BEACON and decision.sender is None
            if outcome.reason.is_suspicious and not is_unconfirmed:
                self._alarm, self._alarm_at = outcome.message, self._now()

    def status(self) -> Status:
        """Return the current diagnostics."""
        values = {'beacons': self._beacons_file, 'images with a pose': str(self._fixes)}
        values |= {f'images without: {reason}': str(number) for reason, number in self._no_fixes.items()}
        values |= {f'commands {kind}': str(number) for kind, number in self._commands.items()}
        values |= {f'{sender} message': text for sender, text in self._messages.items()}
        if self._latest is None:
            return Status(Level.WARN, 'no image yet', values)
        values |= _reception_values(self._latest) | {
            'processing time of the latest image [ms]': f'{1e3 * self._duration:.1f}'
        }
        warnings = self._warnings(self._latest)
        result = self._latest.result
        if not isinstance(result, BeaconFix):
            return Status(Level.WARN, '; '.join([f'no fix: {result.reason.value}', *warnings]), values)
        return Status(Level.WARN if warnings else Level.OK, '; '.join(['fix', *warnings]), values)

    def _warnings(self, output: ReceiverOutput) -> list[str]:
        warnings = [_describe(anomaly) for anomaly in output.result.anomalies]
        warnings += [
            f'a lamp sends the ID {lamp.unknown_id}, which is not in the beacons file'
            for lamp in output.lamps
            if lamp.unknown_id is not None
        ]
        rejection = self._authorizer.permanent_rejection
        if rejection is not None and rejection.reason is not RejectionReason.NO_KEY:
            warnings.append(rejection.message)
        if self._now() - self._alarm_at < _ALARM_DURATION:
            warnings.append(self._alarm)
        return warnings


def _describe(anomaly: BeaconAnomaly) -> str:
    other = '' if anomaly.swapped_with is None else f' with {anomaly.swapped_with}'
    return f'lamp {anomaly.id} {anomaly.kind.value}{other}'


def _reception_values(output: ReceiverOutput) -> dict[str, str]:
    names = sorted(lamp.beacon for lamp in output.lamps if lamp.beacon is not None)
    values = {'lamps in view': str(len(output.lamps)), 'beacons in view': ', '.join(map(str, names)) or 'none'}
    skipped = Counter(lamp.skip_reason.value for lamp in output.lamps if lamp.skip_reason is not None)
    values |= {f'lamps {skip_reason}': str(number) for skip_reason, number in skipped.items()}
    result = output.result
    if not isinstance(result, BeaconFix):
        return values | {'detail': result.detail}
    pose, sigmas = result.T_map_base, result.covariance.diagonal() ** 0.5
    return values | {
        'beacons used': str(int(result.used.sum())),
        'x, y, yaw': f'{pose.x:.4f} m, {pose.y:.4f} m, {pose.yaw:.4f} rad',
        'sigma x, y, yaw': f'{sigmas[0]:.4f} m, {sigmas[1]:.4f} m, {sigmas[3]:.4f} rad',
        'height of base_frame': f'{result.height:.4f} m',
    }
