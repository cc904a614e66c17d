"""Errors of files; each message is one line that names file, field and remedy."""

from floor_localizer.core.floor_localizer_error import FloorLocalizerError


class DotMapError(FloorLocalizerError):
    """A dot map cannot be read or written."""
