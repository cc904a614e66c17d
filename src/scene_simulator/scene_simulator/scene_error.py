"""The one exception root of the simulator."""

from __future__ import annotations


class SceneError(ValueError):
    """A scene that cannot be built as asked; the message is one line that says why."""
