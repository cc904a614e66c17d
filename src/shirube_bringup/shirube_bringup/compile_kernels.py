"""Compiles the numba kernels that render the sensor images."""

from __future__ import annotations

from shirube_bringup.building import lamp_waveforms
from shirube_bringup.render_worker import compile_render_kernels
from vlc_beacon.core.authorization.command_key import CommandKey


def compile_kernels() -> None:
    """Render one image of each sensor."""
    compile_render_kernels(0, lamp_waveforms(CommandKey(bytes(32))))
