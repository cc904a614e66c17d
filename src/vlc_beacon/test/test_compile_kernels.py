"""No kernel is compiled after `compile_kernels`."""

import subprocess
import sys

import pytest

PROGRAM = """
import importlib, pkgutil
import vlc_beacon.core
from numba.core.dispatcher import Dispatcher
from vlc_beacon.core.settings import ReceiverSettings
from vlc_beacon.core.receiver.compile_kernels import compile_kernels

modules = [importlib.import_module(m.name) for m in pkgutil.walk_packages(vlc_beacon.core.__path__, 'vlc_beacon.core.')]
for shutter in ('global', 'rolling'):
    compile_kernels(ReceiverSettings(shutter))
kernels = {o for m in modules for o in vars(m).values() if isinstance(o, Dispatcher)}
inner = {name for k in kernels for name in k.py_func.__code__.co_names}
outer = [k for k in kernels if k.__name__ not in inner]
print(len(outer), *[k.__name__ for k in outer if not k.signatures])
"""


@pytest.mark.newest_set_only
def test_each_kernel_was_compiled() -> None:
    """Those that only other kernels call are part of their callers."""
    told = subprocess.run([sys.executable, '-c', PROGRAM], capture_output=True, text=True, check=True)
    count, *cold = told.stdout.split()
    assert int(count) >= 8
    assert cold == []
