"""What the node publishes beside poses: markers, the debug image and the diagnostics of the receiver."""

from collections import Counter
from collections.abc import Callable, Iterable
from time import monotonic

import cv2
import numpy as np
from numpy.typing import NDArray
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from shirube_ros.diagnostics import Level, Status
from vlc_beacon.core.authorization.command_authorizer import Accepted, CommandAuthorizer, RejectionReason
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.pose.pose_fix import BeaconAnomaly, BeaconFix
from vlc_beacon.core.receiver.beacon_receiver import ReceiverOutput

_SEEN = ColorRGBA(r=0.1, g=0.8, b=0.2, a=1.0)
_SUSPECT = ColorRGBA(r=0.9, g=0.1, b=0.1, a=1.0)
_UNSEEN = ColorRGBA(r=0.5, g=0.5, b=0.5, a=1.0)
_TEXT = ColorRGBA(r=1.0, g=1.0, b=1.0, a=1.0)
_TEXT_HEIGHT = 0.15
"""[m]"""


def beacon_markers(beacons: Iterable[Beacon], output: ReceiverOutput, header: Header) -> MarkerArray:
    """Return markers with IDs: visible beacons green, anomalous ones red, the others grey."""
    seen = {lamp.beacon for lamp in output.lamps}
    suspect = {anomaly.id for anomaly in output.result.anomalies}
    markers = []
    for beacon in beacons:
        colour = _SUSPECT if beacon.id in suspect else _SEEN if beacon.id in seen else _UNSEEN
        markers.append(_marker(beacon, header, 'lamps', Marker.SPHERE, colour, 2.0 * beacon.radius))
        name = _marker(beacon, header, 'ids', Marker.TEXT_VIEW_FACING, _TEXT, _TEXT_HEIGHT)
        name.text = str(beacon.id)
        name.pose.position.z += beacon.radius + _TEXT_HEIGHT
        markers.append(name)
    return MarkerArray(markers=markers)


def _marker(beacon: Beacon, header: Header, namespace: str, kind: int, colour: ColorRGBA, size: float) -> Marker:
    marker = Marker(header=header, ns=namespace, id=beacon.id, type=kind, action=Marker.ADD, color=colour)
    marker.pose.orientation.w = 1.0
    marker.pose.position.x, marker.pose.position.y, marker.pose.position.z = beacon.xyz
    marker.scale.x = marker.scale.y = marker.scale.z = size
    return marker


_IDENTIFIED, _UNKNOWN, _UNIDENTIFIED = (60, 220, 60), (40, 40, 230), (0, 200, 255)
_MARGIN = 3.0
"""Gap between a lamp and its circle [px]."""
_SUBPIXEL_BITS = 4
_FONT_SCALE = 0.5


def draw_debug_image(pixels: NDArray[np.uint8], output: ReceiverOutput) -> NDArray[np.uint8]:
    """Draw lamps with a known ID green, unknown ID red, no ID yellow, and the pose or the reason for none.

    Args:
        pixels: grey image, shape (h, w), or BGR image, shape (h, w, 3); not modified.
        output: receiver output of the image.

    Returns:
        BGR image, shape (h, w, 3).
    """
    coloured = cv2.cvtColor(pixels, cv2.COLOR_GRAY2BGR) if pixels.ndim == 2 else pixels
    canvas = np.array(coloured, dtype=np.uint8)
    unit = 1 << _SUBPIXEL_BITS
    for lamp in output.lamps:
        name = lamp.beacon if lamp.beacon is not None else lamp.unknown_id
        colour = _UNIDENTIFIED if name is None else _IDENTIFIED if lamp.beacon is not None else _UNKNOWN
        u, v = (float(position) for position in lamp.sample.centre)
        reach = lamp.sample.radius + _MARGIN
        centre = (round(u * unit), round(v * unit))
        cv2.circle(canvas, centre, round(reach * unit), colour, 1, cv2.LINE_AA, _SUBPIXEL_BITS)
        if name is not None:
            _put_text(canvas, str(name), (round(u + reach) + 2, round(v)), colour)
    _put_text(canvas, _headline(output), (4, 18), (255, 255, 255))
    return canvas


def _headline(output: ReceiverOutput) -> str:
    result = output.result
    if not isinstance(result, BeaconFix):
        return f'no fix: {result.reason.value}'
    pose = result.T_map_base
    return f'{pose.x:.3f} {pose.y:.3f} m {pose.yaw:.3f} rad'


def _put_text(canvas: NDArray[np.uint8], text: str, position: tuple[int, int], colour: tuple[int, int, int]) -> None:
    for shade, width in (((0, 0, 0), 3), (colour, 1)):
        cv2.putText(canvas, text, position, cv2.FONT_HERSHEY_SIMPLEX, _FONT_SCALE, shade, width, cv2.LINE_AA)


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
