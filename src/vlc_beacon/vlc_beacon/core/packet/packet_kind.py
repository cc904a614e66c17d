"""Packet kind, the first two bits of every packet."""

from enum import IntEnum

KIND_SHIFT = 6
"""The kind is in the two highest bits of the first byte; 0 is invalid, so that darkness is not a packet."""


class PacketKind(IntEnum):
    """Kind of a packet."""

    ID = 1
    DATA = 2
    COMMAND = 3
