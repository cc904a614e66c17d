"""A little workspace, in a folder whose name has a space, is built and run for real."""

import os
import subprocess
from pathlib import Path

import pytest

from shirube_cli import kernel_cache
from shirube_cli.project import CommandError
from shirube_cli.workspace import build_workspace, digest_package, find_executable, overlay_environment

pytestmark = pytest.mark.newest_set_only

SETUP = """
from setuptools import setup

setup(
    name='probe', version='0', packages=['probe'],
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/probe']), ('share/probe', ['package.xml'])
    ],
    entry_points={'console_scripts': ['tell = probe.tell:main']},
)
"""
PACKAGE_XML = """
<package format="3">
  <name>probe</name><version>0.0.0</version><description>A probe.</description>
  <maintainer email="a@b.c">A</maintainer><license>Apache-2.0</license>
  <export><build_type>ament_python</build_type></export>
</package>
"""


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    # The machine code of the repository, which other tests use, is not for these sources and would be removed.
    monkeypatch.setattr(kernel_cache, 'kernel_folder', lambda _: tmp_path / 'numba')
    root = tmp_path / 'with a space'
    files = {
        'setup.py': SETUP,
        'setup.cfg': '[install]\ninstall_scripts=$base/lib/probe\n',
        'package.xml': PACKAGE_XML.strip(),
        'resource/probe': '',
        'probe/__init__.py': '',
        'probe/tell.py': 'def main():\n    print("first")\n',
        'probe/gone.py': '',
    }
    for name, text in files.items():
        path = root / 'src' / 'probe' / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    (root / 'ros2_ws').mkdir()
    (root / 'ros2_ws' / 'src').symlink_to('../src')
    return root


def tell(root: Path) -> str:
    command = find_executable(root, 'probe', 'tell')
    environment = overlay_environment(root)
    return subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout.strip()


def test_failing_build_is_tried_again_a_changed_package_is_built_again_and_an_unchanged_one_is_not(root: Path) -> None:
    setup = root / 'src/probe/setup.py'
    setup.write_text('raise SystemExit("broken on purpose")')
    with pytest.raises(CommandError, match='colcon build failed'):
        build_workspace(root)
    setup.write_text(SETUP)
    build_workspace(root)
    assert tell(root) == 'first'
    with pytest.raises(CommandError, match=r"no executable 'tel'; choose one of: tell"):
        find_executable(root, 'probe', 'tel')
    executable = Path(find_executable(root, 'probe', 'tell')[-1])
    assert executable == root / 'ros2_ws/install/probe/lib/probe/tell'
    assert os.access(executable, os.X_OK)
    built = executable.stat().st_mtime_ns
    build_workspace(root)
    assert executable.stat().st_mtime_ns == built

    (root / 'src/probe/probe/tell.py').write_text('def main():\n    print("second")\n')
    (root / 'src/probe/probe/gone.py').unlink()
    build_workspace(root)
    assert tell(root) == 'second'
    assert not list((root / 'ros2_ws/install').rglob('gone.py'))


def test_digest_sees_contents_names_and_modes_but_no_tests(root: Path) -> None:
    package = root / 'src' / 'probe'
    module = package / 'probe' / 'gone.py'
    seen = {digest_package(package)}
    (package / 'test').mkdir()
    (package / 'test' / 'test_probe.py').write_text('assert True')
    assert digest_package(package) in seen
    for change in (
        lambda: module.write_text('x = 1'),
        lambda: module.chmod(0o755),
        lambda: module.rename(module.with_name('other.py')),
    ):
        change()
        assert digest_package(package) not in seen
        seen.add(digest_package(package))


def test_an_unknown_package_is_answered_with_the_known_ones(root: Path) -> None:
    with pytest.raises(CommandError, match=r"no package 'prob'; choose one of: probe"):
        find_executable(root, 'prob', 'tell')
