"""No kernel of the localizers is compiled after `compile_kernels`."""

import subprocess
import sys

import pytest

PROGRAM = """
import importlib, pkgutil
import {package}.core as core
from numba.core.dispatcher import Dispatcher
{compile}
modules = [importlib.import_module(m.name) for m in pkgutil.walk_packages(core.__path__, core.__name__ + '.')]
kernels = {{o for m in modules for o in vars(m).values() if isinstance(o, Dispatcher)}}
inner = {{name for k in kernels for name in k.py_func.__code__.co_names}}
outer = [k for k in kernels if k.__name__ not in inner]
print(len(outer), *[k.__name__ for k in outer if not k.signatures])
"""
LANDMARKS = 'from stereo_landmark.core.compile_kernels import compile_kernels; compile_kernels()'
LAMPS = """
from vlc_beacon.core.settings import ReceiverSettings
from vlc_beacon.core.receiver.compile_kernels import compile_kernels
[compile_kernels(ReceiverSettings(shutter)) for shutter in ('global', 'rolling')]
"""


@pytest.mark.newest_set_only
@pytest.mark.parametrize(
    ('package', 'compile_all', 'least'), [('stereo_landmark', LANDMARKS, 20), ('vlc_beacon', LAMPS, 8)]
)
def test_each_kernel_was_compiled(package: str, compile_all: str, least: int) -> None:
    """Kernels that only other kernels call are compiled with their callers."""
    program = PROGRAM.format(package=package, compile=compile_all)
    completed = subprocess.run([sys.executable, '-c', program], capture_output=True, text=True, check=True)
    count, *cold = completed.stdout.split()
    assert int(count) >= least
    assert cold == []
