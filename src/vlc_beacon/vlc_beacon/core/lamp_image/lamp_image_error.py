"""Error for images that the lamp detector cannot process."""

from vlc_beacon.core.vlc_beacon_error import VlcBeaconError


class LampImageError(VlcBeaconError):
    """The image has a wrong type or shape."""
