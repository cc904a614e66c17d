"""Interface of a scene that a stereo camera can render."""

from __future__ import annotations

from typing import Protocol

from scene_simulator.corridor_light import CorridorLight
from scene_simulator.corridor_shape import ShapeTable


class PaintedScene(Protocol):
    """Flat shapes in the order from behind to before, in some light."""

    @property
    def table(self) -> ShapeTable:
        """All shapes."""

    @property
    def light(self) -> CorridorLight:
        """The light on them."""
