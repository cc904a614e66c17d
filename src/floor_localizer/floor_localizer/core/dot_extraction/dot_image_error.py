"""The error that an image raises which no dots can be taken from."""

from __future__ import annotations

from floor_localizer.core.floor_localizer_error import FloorLocalizerError


class DotImageError(FloorLocalizerError):
    """An image of a type or shape that dot extraction does not take; the message is one line."""
