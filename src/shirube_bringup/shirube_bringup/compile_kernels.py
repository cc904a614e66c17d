"""Compiles the numba kernels that render the sensor images."""

from shirube_bringup.building import lamp_waveforms
from shirube_bringup.render_worker import compile_render_kernels, initialize_worker
from vlc_beacon.core.authorization.command_key import CommandKey


def compile_kernels() -> None:
    """Render one image of each sensor."""
    initialize_worker(0, lamp_waveforms(CommandKey(bytes(32))))
    compile_render_kernels()
