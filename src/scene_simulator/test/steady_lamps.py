"""Lamps that play nothing, for tests of all that is not light code."""

from __future__ import annotations

from light_waveform import steady_light
from scene_simulator.mission_lamps import LAMPS

STEADY = {name: steady_light() for name in LAMPS}
