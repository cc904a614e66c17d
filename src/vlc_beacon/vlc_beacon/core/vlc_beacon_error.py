"""The root exception of the package."""


class VlcBeaconError(ValueError):
    """Invalid input; the message is one line with the field and the remedy."""
