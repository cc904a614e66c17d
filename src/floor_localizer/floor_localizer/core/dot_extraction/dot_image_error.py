"""The error that an image raises which no dots can be taken from."""

from __future__ import annotations


class DotImageError(ValueError):
    """An image of a type or shape that dot extraction does not take; the message is one line."""
