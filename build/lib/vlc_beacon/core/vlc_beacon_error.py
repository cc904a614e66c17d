"""The exceptions of the package."""


class VlcBeaconError(ValueError):
    """Invalid input; the message is one line with the field and the remedy."""


class LampImageError(VlcBeaconError):
    """The image has a wrong type or shape."""


class PacketError(VlcBeaconError):
    """A value does not fit into a packet."""


class LampFrameError(VlcBeaconError):
    """A frame that the lamp firmware would reject."""
