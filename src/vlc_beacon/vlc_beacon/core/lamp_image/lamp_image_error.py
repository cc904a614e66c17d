"""Images that lamps cannot be looked for in."""

from vlc_beacon.core.vlc_beacon_error import VlcBeaconError


class LampImageError(VlcBeaconError):
    """The image has a wrong type or shape."""
