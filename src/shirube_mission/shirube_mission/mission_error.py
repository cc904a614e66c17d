"""The one exception root of the mission."""

from __future__ import annotations


class MissionError(Exception):
    """The mission cannot go on; the message is one line that says why and what to do."""
