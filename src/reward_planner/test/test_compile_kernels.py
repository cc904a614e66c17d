"""No kernel is compiled while the robot drives."""

import subprocess
import sys
from pathlib import Path

import pytest

from reward_planner.core.compile_kernels import compile_kernels
from reward_planner.core.navigator import NavigatorSettings
from reward_planner.core.settings import VoxelSettings
from shirube_core.geometry import CameraMount


@pytest.mark.newest_set_only
def test_nothing_is_compiled_while_the_robot_drives():
    program = Path(__file__).parent / 'warm_drive.py'
    run = subprocess.run(  # in a process in which no other test has compiled anything
        [sys.executable, str(program)], capture_output=True, text=True, timeout=300, check=False
    )
    assert (run.stderr, run.stdout.split(), run.returncode) == ('', [], 0)


@pytest.mark.parametrize('ranges', [(0.0, 0.5), (4.0, 5.0), (0.3, 50.0)])
@pytest.mark.parametrize('height', [-9.0, 0.3, 9.0])
def test_kernels_compile_with_any_settings(ranges, height):
    voxels = VoxelSettings(resolution=0.5, range_min=ranges[0], range_max=ranges[1])
    compile_kernels(CameraMount((0.0, 0.0, height)), NavigatorSettings(voxels))
