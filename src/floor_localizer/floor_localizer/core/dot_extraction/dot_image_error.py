"""The error of an image from which dots cannot be extracted."""

from __future__ import annotations

from floor_localizer.core.floor_localizer_error import FloorLocalizerError


class DotImageError(FloorLocalizerError):
    """The type, shape or size of an image is not supported; the message is one line."""
