"""A tracked lamp with its decoder, confirmed ID and last messages."""

from __future__ import annotations

from collections.abc import Set as AbstractSet
from enum import Enum

from vlc_beacon.core.packet.command_packet import CommandPacket
from vlc_beacon.core.packet.data_packet import DataPacket
from vlc_beacon.core.packet.id_confirmation import IdConfirmation
from vlc_beacon.core.packet.id_packet import IdPacket
from vlc_beacon.core.packet.message_assembly import MessageAssembly
from vlc_beacon.core.packet.packet_reader import ReceivedPacket
from vlc_beacon.core.receiver.lamp_decoder import LampDecoder, LampView
from vlc_beacon.core.receiver.patience import Patience


class Silence(Enum):
    """Reason why a lamp is not decoded."""

    NO_CODE = 'without a code'
    TOO_SMALL = 'too small to be decoded'


class FollowedLamp:
    """A lamp from frame to frame.

    Attributes:
        beacon: confirmed ID, None while unconfirmed.
        stranger: confirmed ID that is not in the beacons file, None for none.
        heard: command packets completed by the last frame.
        said: message completed by the last frame, None for none.
        silence: reason why the lamp is not decoded, None if it is decoded.
    """

    def __init__(
        self, decoder: LampDecoder, known: AbstractSet[int], readable_diameter: float, patience: float
    ) -> None:
        """Start with a new lamp.

        Args:
            decoder: decoder of this lamp.
            known: IDs in the beacons file.
            readable_diameter: minimum diameter for decoding [px].
            patience: acquisition timeout of a lamp without an ID [s].
        """
        self._decoder = decoder
        self._known = known
        self._readable_diameter = readable_diameter
        self._patience = Patience(patience)
        self._confirmation = IdConfirmation()
        self.beacon: int | None = None
        self.stranger: int | None = None
        self._assembly = MessageAssembly()
        self.heard: list[CommandPacket] = []
        self.said: str | bytes | None = None
        self.silence: Silence | None = None

    def see(self, view: LampView) -> None:
        """Process a frame."""
        self.heard, self.said = [], None
        if self._patience.listens(view.stamp) or self.beacon is not None:
            for received in self._decoder.read(view):
                self._patience.hear(view.stamp)
                self._take(received)
        self.silence = self._silence(view) if self._patience.is_over and self.beacon is None else None

    def _silence(self, view: LampView) -> Silence:
        is_small = 2.0 * view.sample.radius < self._readable_diameter
        return Silence.TOO_SMALL if is_small else Silence.NO_CODE

    def _take(self, received: ReceivedPacket) -> None:
        packet = received.packet
        if isinstance(packet, CommandPacket):
            self.heard.append(packet)
        elif isinstance(packet, DataPacket):
            message = self._assembly.add(packet)
            self.said = self.said if message is None else message
        elif isinstance(packet, IdPacket):
            confirmed = self._confirmation.add(packet.beacon)
            if confirmed is not None and confirmed in self._known:
                self.beacon, self.stranger = confirmed, None
            elif confirmed is not None:
                self.beacon, self.stranger = None, confirmed
