"""The root of this package's exceptions."""


class FloorLocalizerError(ValueError):
    """Input that the package cannot use; the message is one line that names file, field and remedy."""
