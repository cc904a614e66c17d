"""Compiles the numba kernels that render the sensor images."""

from __future__ import annotations

from shirube_mission.lamp_programs import lamp_waveforms
from shirube_mission.render_worker import render_one_of_each
from vlc_beacon.core.trust.command_key import CommandKey

_ANY_KEY = CommandKey(bytes(32))


def warm_up() -> None:
    """Render one image of each sensor."""
    render_one_of_each(0, lamp_waveforms(_ANY_KEY))
