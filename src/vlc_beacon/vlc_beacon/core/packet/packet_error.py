"""What a packet cannot carry."""

from vlc_beacon.core.vlc_beacon_error import VlcBeaconError


class PacketError(VlcBeaconError):
    """A value that does not fit into a packet."""
