"""Parses packets of all kinds."""

from dataclasses import dataclass

from vlc_beacon.core.packet.command_packet import CommandPacket, ShortCommandPacket, command_length, read_command_packet
from vlc_beacon.core.packet.data_packet import (
    DATA_OVERHEAD,
    ID_BYTES,
    KIND_SHIFT,
    DataPacket,
    IdPacket,
    PacketKind,
    read_data_packet,
    read_id_packet,
)

Packet = IdPacket | DataPacket | CommandPacket | ShortCommandPacket


@dataclass(frozen=True)
class ReceivedPacket:
    """A packet with a correct checksum, not yet confirmed, and the stamp of its last frame [s]."""

    stamp: float
    packet: Packet


def read_packet(data: bytes) -> Packet | None:
    """Parse a packet; None if it is invalid."""
    return read_id_packet(data) or read_data_packet(data) or read_command_packet(data)


def packet_length(data: bytes) -> int | None:
    """Return the length of the packet at the start of data [bytes], or None if there is none."""
    if len(data) < ID_BYTES:
        return None
    lengths = {
        PacketKind.ID: ID_BYTES,
        PacketKind.DATA: DATA_OVERHEAD + data[2],
        PacketKind.COMMAND: command_length(data[0]),
    }
    return next((length for kind, length in lengths.items() if kind == data[0] >> KIND_SHIFT), None)
