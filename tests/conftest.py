"""Lets tests import the modules that lie beside them, and the light channel of the beacon's tests."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / 'src/vlc_beacon/test')]
