"""The root of this package's exceptions."""


class MotorBridgeError(ValueError):
    """Input that the package cannot use; the message is one line that names the field and the remedy."""
