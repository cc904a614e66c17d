"""A room as a camera sees it that looks up: its ceiling and its lights; the paper's room."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from scene_simulator.ceiling_lamp import CeilingLamp
from scene_simulator.ceiling_surface import CeilingSurface, panelled_ceiling
from scene_simulator.lamp_shape import Disc, LampShape, LedGrid, Rectangle
from scene_simulator.scene_error import SceneError
from scene_simulator.waveform import Waveform, mains_flicker

PAPER_LAMPS = ((0.0, 0.0, 2.5), (0.0, 1.8, 2.5), (1.8, 0.0, 2.5), (1.8, 1.8, 2.5))
"""Places of the paper's panels (3.1) in the map frame [m]."""

PAPER_AREA = ((-2.6, -2.1), (4.4, 3.9))
"""Two corners of the paper's room, 7 x 6 m with the lamps in its middle, in the map frame [m]."""


@dataclass(frozen=True)
class CeilingRoom:
    """What there is to see above.

    Attributes:
        lamps: every light, coded or not.
        surface: the ceiling; none is black.
    """

    lamps: tuple[CeilingLamp, ...] = ()
    surface: CeilingSurface | None = None

    def with_lights(self, lights: Sequence[CeilingLamp]) -> CeilingRoom:
        """Return the room with more lights, counted after the others."""
        return CeilingRoom((*self.lamps, *lights), self.surface)

    def lit(self, ambient: float, contrast: float = 0.1, seed: int = 0) -> CeilingRoom:
        """Return the room with its lights on, a panelled ceiling at the height of the first lamp.

        Args:
            ambient: mean light of the ceiling, in full wells per second of exposure [1/s].
            contrast: of its stains and joints relative to that.
            seed: of the stains.

        Raises:
            SceneError: without a lamp, or as for ``panelled_ceiling``.
        """
        if not self.lamps:
            raise SceneError('a room without a lamp has no height: make its ceiling with panelled_ceiling')
        # A hand's breadth above, so that the lamps' faces are never in its plane.
        surface = panelled_ceiling(self.lamps[0].xyz[2] + 0.02, ambient, contrast, seed)
        return CeilingRoom(self.lamps, surface)


def paper_room(
    waveforms: Sequence[Waveform], shape: LampShape | None = None, brightness: float = 2000.0
) -> CeilingRoom:
    """Return the paper's room (3.1), dark, with four panels of 8 x 8 LEDs.

    Args:
        waveforms: what the four lamps send.
        shape: another shape for all four.
        brightness: of the lamps, in full wells per second of exposure [1/s].

    Raises:
        SceneError: not four waveforms.
    """
    if len(waveforms) != len(PAPER_LAMPS):
        raise SceneError(f'the paper\'s room has four lamps, and {len(waveforms)} waveforms are given')
    face = shape or LedGrid()
    return CeilingRoom(
        tuple(CeilingLamp(p, face, w, brightness) for p, w in zip(PAPER_LAMPS, waveforms, strict=True))
    )


def distractors(brightness: float = 2000.0) -> tuple[CeilingLamp, ...]:
    """Return lights without a code in the paper's room: a spot, a flickering tube and panel, a window.

    Args:
        brightness: of the spot, in full wells per second of exposure [1/s]; the others are dimmer.
    """
    upright = math.pi / 2.0
    mains = mains_flicker()
    return (
        CeilingLamp((0.9, 2.6, 2.48), Disc(0.04), brightness=brightness),
        CeilingLamp((-0.8, 0.9, 2.45), Rectangle(0.03, 1.2), mains, 0.7 * brightness),
        CeilingLamp((2.9, 0.3, 2.5), Rectangle(0.3, 0.3), mains, 0.4 * brightness, phase=0.003),
        CeilingLamp((0.9, 3.9, 1.9), Rectangle(1.6, 1.0), brightness=0.6 * brightness, rpy=(upright, 0.0, 0.0)),
    )
