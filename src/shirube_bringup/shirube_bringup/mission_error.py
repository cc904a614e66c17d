"""The exception of this package."""

from __future__ import annotations


class MissionError(Exception):
    """The mission cannot continue; the message is one line with reason and remedy."""
