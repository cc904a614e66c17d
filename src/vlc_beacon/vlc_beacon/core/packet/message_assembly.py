"""Reassembles messages from the data packets of one lamp."""

from __future__ import annotations

from vlc_beacon.core.packet.data_packet import DataPacket


class MessageAssembly:
    """Reassembles fragmented messages; lamps repeat them, so a missed fragment is received later."""

    def __init__(self) -> None:
        """Start without fragments."""
        self._parts: dict[int, DataPacket] = {}
        self._told: str | bytes | None = None

    def add(self, packet: DataPacket) -> str | bytes | None:
        """Add a fragment and return the completed message; None if incomplete or equal to the last one.

        Args:
            packet: data packet with a correct checksum.
        """
        if not all(_may_be_of_one_message(part, packet) for part in self._parts.values()):
            self._parts.clear()
        self._parts[packet.sequence] = packet
        last = next((part.sequence for part in self._parts.values() if part.is_last), None)
        if last is None or any(number not in self._parts for number in range(last + 1)):
            return None
        content = b''.join(self._parts[number].payload for number in range(last + 1))
        message = content.decode(errors='replace') if packet.is_text else content
        if message == self._told:
            return None
        self._told = message
        return message


def _may_be_of_one_message(one: DataPacket, other: DataPacket) -> bool:
    if (one.tag, one.is_text) != (other.tag, other.is_text):
        return False
    if one.sequence == other.sequence:
        return one == other
    earlier = one if one.sequence < other.sequence else other
    return not earlier.is_last
