"""The errors of this package; each message is one line that names file, field and remedy."""


class FloorLocalizerError(ValueError):
    """Input that the package cannot use; the message is one line that names file, field and remedy."""


class DotImageError(FloorLocalizerError):
    """The type, shape or size of an image is not supported; the message is one line."""


class DotMapError(FloorLocalizerError):
    """A dot map cannot be read or written."""
