"""Architecture rules: allowed imports, pure cores, and limits on the length of files and functions."""

import ast
import re
import sys
import tomllib
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

pytestmark = [pytest.mark.quick, pytest.mark.newest_set_only]

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = sorted(folder.name for folder in (ROOT / 'src').iterdir() if folder.is_dir())
SOURCES_OF = {
    package: sorted(path for path in (ROOT / 'src' / package).glob('*/**/*.py') if 'test' not in path.parts)
    for package in PACKAGES
}
FOLDERS = (*(f'src/{package}' for package in PACKAGES), 'tests', 'benchmarks', 'environment')

# What knows only numbers: folders and files below src/, and what of them is left out.
CORES = ('floor_localizer', 'motor_bridge', 'pose_arbiter', 'reward_planner', 'shirube_camera', 'stereo_landmark')
PURE = (
    *(f'{name}/{name}/core' for name in (*CORES, 'vlc_beacon')),
    *(f'shirube_core/shirube_core/{name}' for name in ('crc.py', 'geometry', 'motion', 'settings', 'waveform.py')),
    *(f'shirube_bags/shirube_bags/{name}.py' for name in ('accuracy', 'errors', 'stamps', 'trajectory')),
    'motor_bridge/motor_bridge/emulator',
    'scene_simulator',
)
NOT_PURE = (
    'motor_bridge/motor_bridge/emulator/pseudo_terminal.py',
    'scene_simulator/scene_simulator/commands',
    'scene_simulator/scene_simulator/messages.py',
)
PURE_LIBRARIES = {'numpy', 'scipy', 'cv2', 'numba', 'reedsolo', 'shirube_core'}
TOUCHES_THE_WORLD = {
    *('io', 'logging', 'os', 'pathlib', 'datetime', 'pickle', 'random'),
    *('shutil', 'socket', 'subprocess', 'sys', 'tempfile', 'time'),
}
LIMITS_A_PROCESS = {'setrlimit', 'umask', 'setlocale', 'alarm', 'setitimer'}
FORBIDDEN_FUNCTIONS = {'open', 'print', 'input', 'eval', 'exec'}
FORBIDDEN_ATTRIBUTES = {
    *('imread', 'imwrite', 'imshow', 'VideoCapture', 'VideoWriter'),
    *('load', 'loadtxt', 'genfromtxt', 'fromfile', 'memmap', 'save', 'savez', 'savetxt', 'tofile'),
    *('read_text', 'read_bytes', 'write_text', 'write_bytes'),
}

# What is imported or started only where it is installed.
OPTIONAL = {'shirube_ros': {'tf2_msgs', 'tf2_ros'}, 'shirube_bringup': {'robot_state_publisher', 'xacro'}}
# What pip alone installs, for one option: rosdistro has no key.
NOT_IN_ROSDISTRO = {'dask', 'distributed'}
ROSDEP_LIST = ROOT / 'tests' / 'rosdep_keys.txt'
# rosdep's key for a Python module that is called otherwise.
ROSDEP_KEYS = {
    **{name: f'python3-{name}' for name in ('aiohttp', 'jsonschema', 'matplotlib', 'numba', 'numpy')},
    **{name: f'python3-{name}' for name in ('reedsolo', 'scipy', 'serial', 'tqdm', 'yaml')},
    'cv2': 'python3-opencv',
    'hypothesis': 'python3-hypothesis',
    'pytest': 'python3-pytest',
    'rosbags': 'python3-rosbags-pip',
}


def is_pure(path: Path) -> bool:
    inside = path.relative_to(ROOT / 'src')
    return any(inside.is_relative_to(p) for p in PURE) and not any(inside.is_relative_to(p) for p in NOT_PURE)


def relative(path: Path) -> str:
    return str(path.relative_to(ROOT))


@cache
def pure_files(package: str) -> list[Path]:
    return [path for path in SOURCES_OF[package] if is_pure(path)]


@dataclass(frozen=True)
class Names:
    """What the rules ask of a file, which is parsed once; names are taken from the modules in ``froms``."""

    imports: set[str]
    froms: set[str]
    calls: set[str]
    attributes: set[str]
    lengths: dict[str, int]


@cache
def names_in(path: Path) -> Names:
    names = Names(set(), set(), set(), set(), {})
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Attribute):
            names.attributes.add(node.attr)
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            names.calls.add(node.func.id)
        elif isinstance(node, ast.Import):
            names.imports.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.froms.add(node.module)
            if not node.level:
                names.imports.add(node.module)
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            assert node.end_lineno is not None
            lines = node.end_lineno - node.lineno
            names.lengths[node.name] = max(lines, names.lengths.get(node.name, 0))
    return names


def imported_modules(path: Path) -> set[str]:
    """Return the first part of every name that is imported anywhere in the file."""
    return {name.split('.')[0] for name in names_in(path).imports}


def rosdep_keys(package: str, files: Iterable[Path]) -> set[str]:
    """Return the keys that the imports of the package's files ask for."""
    modules = {module for path in files for module in imported_modules(path)}
    modules -= set(sys.stdlib_module_names) | NOT_IN_ROSDISTRO | {package, 'setuptools'}
    modules -= {'shirube'} if package == 'shirube_cli' else set()  # its second module, the library
    return {ROSDEP_KEYS.get(module, module) for module in modules}


def declared(package: str, tag: str) -> list[str]:
    return [node.text or '' for node in ET.parse(ROOT / 'src' / package / 'package.xml').iter(tag)]


def test_the_rules_see_the_code() -> None:
    assert sum(is_pure(path) for paths in SOURCES_OF.values() for path in paths) > 5
    assert {'floor_localizer', 'shirube_core', 'shirube_cli'} <= set(PACKAGES)


@pytest.mark.parametrize('package', PACKAGES)
def test_cores_know_only_numbers(package: str) -> None:
    allowed = PURE_LIBRARIES | {package} | set(sys.stdlib_module_names) - TOUCHES_THE_WORLD
    for path in pure_files(package):
        assert imported_modules(path) <= allowed, relative(path)
        assert not names_in(path).calls & FORBIDDEN_FUNCTIONS, relative(path)
        assert not names_in(path).attributes & FORBIDDEN_ATTRIBUTES, relative(path)


@pytest.mark.parametrize('package', PACKAGES)
def test_cores_import_no_part_that_is_not_pure(package: str) -> None:
    for path in pure_files(package):
        for module in names_in(path).froms:
            other = module.split('.')[0]
            target = ROOT / 'src' / other / module.replace('.', '/')
            file = target / '__init__.py' if target.is_dir() else target.with_suffix('.py')
            assert not file.exists() or is_pure(file), f'{relative(path)}: {module}'


@pytest.mark.parametrize('package', PACKAGES)
def test_package_xml_names_what_is_imported_and_no_more(package: str) -> None:
    keys = rosdep_keys(package, SOURCES_OF[package]) | OPTIONAL.get(package, set())
    # Their nodes are started, not imported.
    launched = set(PACKAGES) - keys if package == 'shirube_bringup' else set()
    assert set(declared(package, 'exec_depend')) - launched == keys


@pytest.mark.parametrize('package', PACKAGES)
def test_package_xml_names_what_the_tests_import(package: str) -> None:
    files = sorted((ROOT / 'src' / package / 'test').rglob('*.py'))
    beside = {name for path in [*files, *(ROOT / 'tests').glob('*.py')] for name in (path.stem, path.parent.name)}
    assert rosdep_keys(package, files) - beside <= {
        *declared(package, 'exec_depend'),
        *declared(package, 'test_depend'),
    }


@pytest.mark.parametrize('package', PACKAGES)
def test_rosdep_resolves_every_key(package: str) -> None:
    lines = [line.split() for line in ROSDEP_LIST.read_text().splitlines() if not line.startswith('#')]
    known = {key for key, _ in lines}
    assert {source for _, source in lines} == {'apt', 'pip', 'jazzy'}
    tree = ET.parse(ROOT / 'src' / package / 'package.xml').getroot()
    keys = {node.text for node in tree if node.tag.endswith('depend')} - set(PACKAGES)
    assert keys <= known, f'not in rosdistro: {sorted(map(str, keys - known))}'


@pytest.mark.parametrize('package', PACKAGES)
def test_package_has_the_form_of_an_ament_python_package(package: str) -> None:
    folder = ROOT / 'src' / package
    assert declared(package, 'name') == [package]
    assert declared(package, 'license') == ['Apache-2.0']
    assert declared(package, 'build_type') == ['ament_python']
    assert (folder / 'resource' / package).is_file()
    assert f'lib/{package}' in (folder / 'setup.cfg').read_text()
    assert f'name = {package}' in (folder / 'setup.cfg').read_text()
    assert sorted(folder.glob('test/test_*.py'))
    assert (folder / package / 'py.typed').is_file() or not (folder / package).exists()


def test_packages_depend_on_each_other_without_circles() -> None:
    waiting = {p: set(declared(p, 'exec_depend')) & set(PACKAGES) for p in PACKAGES}
    while waiting:
        free = [package for package, needs in waiting.items() if not needs & set(waiting)]
        assert free, f'import cycle among {sorted(waiting)}'
        for package in free:
            del waiting[package]


def test_pip_users_get_every_package() -> None:
    project = tomllib.loads((ROOT / 'pyproject.toml').read_text())
    assert project['tool']['setuptools']['packages']['find']['where'] == [f'src/{name}' for name in PACKAGES]


@pytest.mark.parametrize('folder', FOLDERS)
def test_files_and_functions_are_short_and_documented(folder: str) -> None:
    for path in (ROOT / folder).rglob('*.py'):
        assert len(path.read_text().splitlines()) <= 300, relative(path)
        assert not re.fullmatch(r'_?(utils?|common|helpers?|misc)', path.stem), relative(path)
        assert [name for name, lines in names_in(path).lengths.items() if lines >= 50] == [], relative(path)


@pytest.mark.parametrize('folder', [*(f'src/{package}/test' for package in PACKAGES), 'tests'])
def test_tests_limit_only_processes_of_their_own(folder: str) -> None:
    # A limit in pytest's process would hold for its log and for every later test, too.
    for path in (ROOT / folder).rglob('*.py'):
        assert not names_in(path).attributes & LIMITS_A_PROCESS, relative(path)
