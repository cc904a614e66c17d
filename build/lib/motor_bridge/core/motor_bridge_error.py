"""Base class of this package's exceptions."""


class MotorBridgeError(ValueError):
    """Invalid input; the message is one line that names the field and the remedy."""
