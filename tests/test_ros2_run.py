"""`ros2 run` itself, where a ROS installation is found."""

import shutil
import subprocess

import pytest


def test_ros2_run_starts_the_installed_programs() -> None:
    ros2 = shutil.which('ros2')
    if ros2 is None:
        pytest.skip('no ROS installation: ros2 is not on the PATH')
    known = subprocess.run([ros2, 'pkg', 'prefix', 'vlc_beacon'], capture_output=True, text=True, check=False)
    if known.returncode != 0:
        pytest.skip('the workspace is not built or sourced: colcon build, then . install/setup.bash')
    command = [ros2, 'run', 'vlc_beacon', 'locate', '--help']
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert '--beacons' in done.stdout
