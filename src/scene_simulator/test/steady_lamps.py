"""Lamps that play nothing, for tests of all that is not light code."""

from scene_simulator.mission.lamps import LAMPS
from shirube_core.waveform import steady_light

STEADY = {name: steady_light() for name in LAMPS}
