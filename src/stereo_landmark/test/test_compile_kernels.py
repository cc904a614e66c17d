"""All numba kernels are compiled in advance."""

import subprocess
import sys

import pytest

PROGRAM = """
import importlib, pkgutil
import stereo_landmark.core
from numba.core.dispatcher import Dispatcher
from stereo_landmark.core.compile_kernels import compile_kernels

names = [m.name for m in pkgutil.walk_packages(stereo_landmark.core.__path__, 'stereo_landmark.core.')]
modules = [importlib.import_module(name) for name in names]
compile_kernels()
kernels = {o for m in modules for o in vars(m).values() if isinstance(o, Dispatcher)}
inner = {name for k in kernels for name in k.py_func.__code__.co_names}
outer = [k for k in kernels if k.__name__ not in inner]
print(len(outer), *[k.__name__ for k in outer if not k.signatures])
"""


@pytest.mark.newest_set_only
def test_each_kernel_was_compiled() -> None:
    """Kernels that only other kernels call are compiled with their callers."""
    completed = subprocess.run([sys.executable, '-c', PROGRAM], capture_output=True, text=True, check=True)
    count, *cold = completed.stdout.split()
    assert int(count) >= 20
    assert cold == []
