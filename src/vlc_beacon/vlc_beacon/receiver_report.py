"""Diagnostics of the node: pose, lamps in view, beacon anomalies and commands."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from time import monotonic

from shirube_ros.diagnostics import Level, Status
from vlc_beacon.core.pose.pose_fix import BeaconDoubt, BeaconFix
from vlc_beacon.core.receiver.beacon_receiver import Reception
from vlc_beacon.core.trust.command_judge import CommandJudge
from vlc_beacon.core.trust.verdict import Accepted, Refusal

_LONGEST_SILENCE = 2.0
"""Time without images after which a warning is published [s]."""
_ALARM = 60.0
"""Duration of the warning after a suspicious command [s]."""


class ReceiverReport:
    """Collects statistics of the receiver output."""

    def __init__(self, beacons_file: str, judge: CommandJudge, now: Callable[[], float] = monotonic) -> None:
        """Start without output.

        Args:
            beacons_file: path of the beacons file, for display.
            judge: authorizer whose permanent rejection is reported.
            now: monotonic clock [s].
        """
        self._beacons_file = beacons_file
        self._judge = judge
        self._now = now
        self._latest: Reception | None = None
        self._latest_at = -float('inf')
        self._duration = 0.0
        self._fixes = 0
        self._no_fixes: Counter[str] = Counter()
        self._commands: Counter[str] = Counter()
        self._messages: dict[str, str] = {}
        self._alarm, self._alarm_at = '', -float('inf')

    def add(self, reception: Reception, duration: float) -> None:
        """Add the output of an image with its processing time ``duration`` [s]."""
        self._latest, self._latest_at, self._duration = reception, self._now(), duration
        if isinstance(reception.result, BeaconFix):
            self._fixes += 1
        else:
            self._no_fixes[reception.result.reason.value] += 1
        self._messages |= dict(messages_of(reception))
        for verdict in reception.verdicts:
            answer = verdict.answer
            if isinstance(answer, Accepted):
                self._commands['accepted'] += 1
                continue
            self._commands[f'rejected: {answer.reason.value}'] += 1
            # A genuine lamp may send commands before its ID is confirmed.
            is_early = answer.reason is Refusal.OTHER_BEACON and verdict.speaker is None
            if answer.reason.is_suspicious and not is_early:
                self._alarm, self._alarm_at = answer.message, self._latest_at

    def status(self) -> Status:
        """Return the current diagnostics."""
        values = {'beacons': self._beacons_file, 'images with a pose': str(self._fixes)}
        values |= {f'images without: {reason}': str(number) for reason, number in self._no_fixes.items()}
        values |= {f'commands {kind}': str(number) for kind, number in self._commands.items()}
        values |= {f'{speaker} message': words for speaker, words in self._messages.items()}
        if self._latest is None:
            return Status(Level.WARN, 'no image yet; check the topics image_raw and camera_info', values)
        values |= _reception_values(self._latest) | {
            'processing time of the latest image [ms]': f'{1e3 * self._duration:.1f}'
        }
        if self._now() - self._latest_at > _LONGEST_SILENCE:
            return Status(Level.WARN, 'images have stopped; check the camera', values)
        warnings = self._warnings(self._latest)
        result = self._latest.result
        if not isinstance(result, BeaconFix):
            return Status(Level.WARN, '; '.join([f'no fix: {result.reason.value}', *warnings]), values)
        return Status(Level.WARN if warnings else Level.OK, '; '.join(['fix', *warnings]), values)

    def _warnings(self, reception: Reception) -> list[str]:
        warnings = [_in_words(doubt) for doubt in reception.result.doubts]
        warnings += [
            f'a lamp sends the ID {lamp.stranger}, which is not in the beacons file'
            for lamp in reception.lamps
            if lamp.stranger is not None
        ]
        standing = self._judge.standing_refusal
        if standing is not None and standing.reason is not Refusal.NO_KEY:
            warnings.append(standing.message)
        if self._now() - self._alarm_at < _ALARM:
            warnings.append(self._alarm)
        return warnings


def messages_of(reception: Reception) -> list[tuple[str, str]]:
    """Return sender and text of the messages in an image; bytes in hexadecimal, text quoted."""
    return [
        ('a lamp' if lamp.beacon is None else f'lamp {lamp.beacon}', _quoted(lamp.said))
        for lamp in reception.lamps
        if lamp.said is not None
    ]


def _quoted(message: str | bytes) -> str:
    return message.hex() if isinstance(message, bytes) else repr(message)


def _in_words(doubt: BeaconDoubt) -> str:
    if doubt.swapped_with is not None:
        return f'lamp {doubt.id} {doubt.kind.value} with {doubt.swapped_with}'
    return f'lamp {doubt.id} {doubt.kind.value}'


def _reception_values(reception: Reception) -> dict[str, str]:
    names = sorted(lamp.beacon for lamp in reception.lamps if lamp.beacon is not None)
    values = {
        'lamps in view': str(len(reception.lamps)),
        'beacons in view': ', '.join(map(str, names)) or 'none',
    }
    silent = Counter(lamp.silence.value for lamp in reception.lamps if lamp.silence is not None)
    values |= {f'lamps {silence}': str(number) for silence, number in silent.items()}
    result = reception.result
    if not isinstance(result, BeaconFix):
        return values | {'detail': result.detail}
    pose, sigmas = result.T_map_base, result.covariance.diagonal() ** 0.5
    return values | {
        'beacons used': str(int(result.used.sum())),
        'x, y, yaw': f'{pose.x:.4f} m, {pose.y:.4f} m, {pose.yaw:.4f} rad',
        'sigma x, y, yaw': f'{sigmas[0]:.4f} m, {sigmas[1]:.4f} m, {sigmas[3]:.4f} rad',
        'height of base_frame': f'{result.height:.4f} m',
    }
