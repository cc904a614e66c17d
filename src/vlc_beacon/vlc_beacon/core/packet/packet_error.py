"""Error of packet contents."""

from vlc_beacon.core.vlc_beacon_error import VlcBeaconError


class PacketError(VlcBeaconError):
    """A value does not fit into a packet."""
