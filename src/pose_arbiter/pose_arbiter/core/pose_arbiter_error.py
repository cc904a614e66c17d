"""Base class of this package's exceptions."""


class PoseArbiterError(ValueError):
    """Input that the package cannot use; the message is one line that names the field and the remedy."""
