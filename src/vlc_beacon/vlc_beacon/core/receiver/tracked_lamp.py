"""A tracked lamp with its decoder, confirmed ID and last messages."""

from __future__ import annotations

from collections.abc import Set as AbstractSet
from enum import Enum

from vlc_beacon.core.packet.command_packet import CommandPacket
from vlc_beacon.core.packet.data_packet import DataPacket, MessageAssembler
from vlc_beacon.core.packet.id_packet import IdPacket
from vlc_beacon.core.packet.packet_reader import ReceivedPacket
from vlc_beacon.core.receiver.lamp_decoder import LampDecoder, LampView


class IdConfirmation:
    """Confirms an ID after two equal consecutive ID packets of one lamp."""

    def __init__(self) -> None:
        """Start without packets."""
        self._last: int | None = None

    def add(self, beacon: int) -> int | None:
        """Add the ID of one packet and return the confirmed ID, None while it is unconfirmed."""
        confirmed = beacon if beacon == self._last else None
        self._last = beacon
        return confirmed


BACKOFF_TIME = 60.0
"""Pause between acquisition attempts [s]."""


class AcquisitionBackoff:
    """Alternates between acquisition and pause while no packet is received.

    Args:
        seconds: duration of an acquisition attempt [s].
    """

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._since: float | None = None
        self._has_timed_out = False

    @property
    def has_timed_out(self) -> bool:
        """Whether an acquisition attempt has timed out since the last packet."""
        return self._has_timed_out

    def is_active(self, stamp: float) -> bool:
        """Return whether to decode the lamp at a time [s]."""
        if self._since is None or stamp < self._since or stamp >= self._since + self._seconds + BACKOFF_TIME:
            self._since = stamp
        self._has_timed_out |= stamp >= self._since + self._seconds
        return stamp < self._since + self._seconds

    def reset(self, stamp: float) -> None:
        """Restart the timeout after a received packet [s]."""
        self._since, self._has_timed_out = stamp, False


class SkipReason(Enum):
    """Reason why a lamp is not decoded."""

    NO_CODE = 'without a code'
    TOO_SMALL = 'too small to be decoded'


class TrackedLamp:
    """A lamp from frame to frame.

    Attributes:
        beacon: confirmed ID, None while unconfirmed.
        unknown_id: confirmed ID that is not in the beacons file, None for none.
        commands: command packets completed by the last frame.
        message: message completed by the last frame, None for none.
        skip_reason: reason why the lamp is not decoded, None if it is decoded.
    """

    def __init__(
        self,
        decoder: LampDecoder,
        known: AbstractSet[int],
        readable_diameter: float,
        acquisition_timeout: float,
    ) -> None:
        """Start with a new lamp.

        Args:
            decoder: decoder of this lamp.
            known: IDs in the beacons file.
            readable_diameter: minimum diameter for decoding [px].
            acquisition_timeout: acquisition timeout of a lamp without an ID [s].
        """
        self._decoder = decoder
        self._known = known
        self._readable_diameter = readable_diameter
        self._acquisition_timeout = AcquisitionBackoff(acquisition_timeout)
        self._confirmation = IdConfirmation()
        self.beacon: int | None = None
        self.unknown_id: int | None = None
        self._assembly = MessageAssembler()
        self.commands: list[CommandPacket] = []
        self.message: str | bytes | None = None
        self.skip_reason: SkipReason | None = None

    def update(self, view: LampView) -> None:
        """Process a frame."""
        self.commands, self.message = [], None
        if self._acquisition_timeout.is_active(view.stamp) or self.beacon is not None:
            for received in self._decoder.read(view):
                self._acquisition_timeout.reset(view.stamp)
                self._on_packet(received)
        self.skip_reason = (
            self._find_skip_reason(view)
            if self._acquisition_timeout.has_timed_out and self.beacon is None
            else None
        )

    def _find_skip_reason(self, view: LampView) -> SkipReason:
        is_small = 2.0 * view.sample.radius < self._readable_diameter
        return SkipReason.TOO_SMALL if is_small else SkipReason.NO_CODE

    def _on_packet(self, received: ReceivedPacket) -> None:
        packet = received.packet
        if isinstance(packet, CommandPacket):
            self.commands.append(packet)
        elif isinstance(packet, DataPacket):
            message = self._assembly.add(packet)
            self.message = self.message if message is None else message
        elif isinstance(packet, IdPacket):
            confirmed = self._confirmation.add(packet.beacon)
            if confirmed is not None and confirmed in self._known:
                self.beacon, self.unknown_id = confirmed, None
            elif confirmed is not None:
                self.beacon, self.unknown_id = None, confirmed
