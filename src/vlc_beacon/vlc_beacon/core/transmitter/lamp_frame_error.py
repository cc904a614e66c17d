"""Error of lamp frames."""

from vlc_beacon.core.vlc_beacon_error import VlcBeaconError


class LampFrameError(VlcBeaconError):
    """A frame that the lamp firmware would reject."""
