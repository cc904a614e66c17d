"""The methods of the suite as a library: no ROS is running, lists and numbers are welcome.

Each call returns a small record: a pose with its covariance, or the reason for none. An argument that cannot be used
raises an `InputError`, or the package's own error, of one line with the remedy. The first call of a method compiles
its kernels once and says so.
"""

from shirube.inputs import InputError, choose_cache

choose_cache()

from shirube import floor, lamps, stereo  # noqa: E402 numba reads its folder at import
from shirube.fusion import fuse  # noqa: E402
from shirube.planning import plan  # noqa: E402
from shirube.results import FusedResult, LampResult, PlaceResult, Result, RouteResult  # noqa: E402
from shirube_core.geometry import PinholeCamera as Camera  # noqa: E402

__all__ = [
    'Camera',
    'FusedResult',
    'InputError',
    'LampResult',
    'PlaceResult',
    'Result',
    'RouteResult',
    'floor',
    'fuse',
    'lamps',
    'plan',
    'stereo',
]
