"""Plain patches as a scene, for tests of the renderer."""

from dataclasses import dataclass

from scene_simulator.corridor.drawing import Drawing
from scene_simulator.corridor.scene import CorridorScene
from scene_simulator.corridor.shapes import (
    CorridorLight,
    FlatShape,
    Landmark,
    Paint,
    RoundLandmark,
    SquareLandmark,
    Surface,
    facing_wall,
)

GROUND, BRIGHT = 0.2, 0.8
EVEN = CorridorLight(1.0, (0.0, 0.0, 0.0))


@dataclass(frozen=True)
class Patches:
    """A wall of one grey with a brighter rectangle and a brighter disc."""

    square: SquareLandmark
    disc: RoundLandmark
    name: str = 'patches'
    position: tuple[float, float] = (0.0, 0.0)

    @property
    def surface(self) -> Surface:
        return self.square.surface

    def shapes(self) -> list[FlatShape]:
        drawing = Drawing(self.surface)
        drawing.rectangle((-20.0, -20.0), (20.0, 20.0), Paint(GROUND))
        drawing.rectangle(self.square.low, self.square.high, Paint(BRIGHT))
        drawing.disc(self.disc.centre, self.disc.radius, Paint(BRIGHT))
        return drawing.shapes

    def landmarks(self) -> list[Landmark]:
        return [self.square, self.disc]


def patches() -> CorridorScene:
    """Return a panel on the left and a round meter on the right, on the wall x = 0."""
    panel = SquareLandmark('panel', facing_wall(0.0), (-0.7, 0.9), (-0.1, 1.5))
    meter = RoundLandmark('meter', facing_wall(0.0), (0.4, 1.3), 0.25)
    return CorridorScene((Patches(panel, meter),), EVEN)


def plain_wall() -> CorridorScene:
    """Return the same wall with nothing on it that is in view."""
    panel = SquareLandmark('panel', facing_wall(0.0), (-19.0, 18.0), (-18.0, 19.0))
    return CorridorScene((Patches(panel, RoundLandmark('meter', facing_wall(0.0), (19.0, 19.0), 0.1)),), EVEN)
