"""Reassembles messages from the data packets of one lamp."""

from __future__ import annotations

from vlc_beacon.core.packet.data_packet import DataPacket


class MessageAssembler:
    """Reassembles fragmented messages; lamps repeat them, so a missed fragment is received later."""

    def __init__(self) -> None:
        """Start without fragments."""
        self._parts: dict[int, DataPacket] = {}
        self._last_message: str | bytes | None = None

    def add(self, packet: DataPacket) -> str | bytes | None:
        """Add a fragment and return the completed message; None if incomplete or equal to the last one.

        Args:
            packet: data packet with a correct checksum.
        """
        if not all(_are_compatible(part, packet) for part in self._parts.values()):
            self._parts.clear()
        self._parts[packet.sequence] = packet
        last = next((part.sequence for part in self._parts.values() if part.is_last), None)
        if last is None or any(number not in self._parts for number in range(last + 1)):
            return None
        content = b''.join(self._parts[number].payload for number in range(last + 1))
        message = content.decode(errors='replace') if packet.is_text else content
        if message == self._last_message:
            return None
        self._last_message = message
        return message


def _are_compatible(one: DataPacket, other: DataPacket) -> bool:
    if (one.tag, one.is_text) != (other.tag, other.is_text):
        return False
    if one.sequence == other.sequence:
        return one == other
    earlier = one if one.sequence < other.sequence else other
    return not earlier.is_last
