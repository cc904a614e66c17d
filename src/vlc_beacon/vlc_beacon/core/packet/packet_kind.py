"""The first two bits of every packet tell its kind."""

from enum import IntEnum

KIND_SHIFT = 6
"""The kind stands in the two highest bits of the first byte; 0 is no kind, so that darkness says nothing."""


class PacketKind(IntEnum):
    """What a packet is."""

    ID = 1
    DATA = 2
    COMMAND = 3
