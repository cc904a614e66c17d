"""A room as a camera sees it that looks up: its ceiling and its lights; the paper's room."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from scene_simulator.ceiling_lamp import CeilingLamp
from scene_simulator.ceiling_surface import CeilingSurface, panelled_ceiling
from scene_simulator.errors import SceneError
from scene_simulator.lamp_shape import LampShape, LedGrid
from shirube_core.waveform import Waveform

PAPER_LAMPS = ((0.0, 0.0, 2.5), (0.0, 1.8, 2.5), (1.8, 0.0, 2.5), (1.8, 1.8, 2.5))
"""Places of the paper's panels (3.1) in the map frame [m]."""

PAPER_AREA = ((-2.6, -2.1), (4.4, 3.9))
"""Two corners of the paper's room, 7 x 6 m with the lamps in its middle, in the map frame [m]."""


@dataclass(frozen=True)
class CeilingRoom:
    """Ceiling and lights.

    Attributes:
        lamps: every light, coded or not.
        surface: the ceiling; none is black.
    """

    lamps: tuple[CeilingLamp, ...] = ()
    surface: CeilingSurface | None = None

    def with_lights(self, lights: Sequence[CeilingLamp]) -> CeilingRoom:
        """Return the room with more lights, counted after the others."""
        return CeilingRoom((*self.lamps, *lights), self.surface)

    def with_ambient_light(
        self, ambient: float, contrast: float = 0.1, seed: int = 0, flicker: Waveform | None = None
    ) -> CeilingRoom:
        """Return the room with its ceiling in the light: panels just above the first lamp.

        Args:
            ambient: mean light of the ceiling, in full wells per second of exposure [1/s].
            contrast: contrast of the stains and joints relative to the mean light.
            seed: seed of the stains.
            flicker: how the light on the ceiling changes, steady by default.

        Raises:
            SceneError: the room has no lamp, or as for ``panelled_ceiling``.
        """
        if not self.lamps:
            raise SceneError('a room without a lamp has no height: make its ceiling with panelled_ceiling')
        # 2 cm above, so that the lamps' faces are never in its plane.
        height = self.lamps[0].xyz[2] + 0.02
        return CeilingRoom(self.lamps, panelled_ceiling(height, ambient, contrast, seed, flicker))


def paper_room(
    waveforms: Sequence[Waveform], shape: LampShape | None = None, brightness: float = 2000.0
) -> CeilingRoom:
    """Return the paper's room (3.1), dark, with four panels of 8 x 8 LEDs.

    Args:
        waveforms: what the four lamps send, in the order of ``PAPER_LAMPS``.
        shape: another shape for all four.
        brightness: brightness of the lamps, in full wells per second of exposure [1/s].

    Raises:
        SceneError: not four waveforms.
    """
    if len(waveforms) != len(PAPER_LAMPS):
        raise SceneError(f'the room of the paper has 4 lamps: give 4 waveforms, not {len(waveforms)}')
    face = shape or LedGrid()
    lamps = zip(PAPER_LAMPS, waveforms, strict=True)
    return CeilingRoom(tuple(CeilingLamp(xyz, face, waveform, brightness) for xyz, waveform in lamps))
