"""The parameter documentation and the example configuration match the code."""

import importlib.util
import math
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import yaml

from pose_arbiter.core.settings import SourceSettings
from pose_arbiter.node import DEFAULT_SOURCES
from reward_planner.core.safety.safety_settings import SourceSettings as RangeSourceSettings
from reward_planner.interface.monitor_inputs import DEFAULT_SOURCES as RANGE_SOURCES
from shirube_bringup.building import BuildingFiles
from shirube_bringup.nodes import mission_nodes
from shirube_cli.settings_of_nodes import SETTINGS_OF_NODES
from shirube_core.settings import describe_settings, setting, settings_from_values, tunable
from vlc_beacon.files.beacons_file import load_beacons

pytestmark = pytest.mark.newest_set_only

ROOT = Path(__file__).resolve().parents[1]


def page_writer() -> ModuleType:
    spec = importlib.util.spec_from_file_location('write_parameters', ROOT / 'docs' / 'write_parameters.py')
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_of_parameters_is_up_to_date() -> None:
    module = page_writer()
    assert module.PAGE.read_text() == module.parameters_page()


@tunable('rpy')
@dataclass(frozen=True)
class Mounted:
    rpy: tuple[float, float, float] = setting((math.pi, 0.0, -math.pi / 2), 'how it is turned', 'rad')
    mode: str = setting('a', 'either a|b', choices=('a', 'b'))


def test_the_table_has_a_row_of_equal_cells_for_each_setting() -> None:
    assert page_writer().settings_table(Mounted).splitlines() == [
        '| setting | type | default | unit | allowed | at run time | meaning |',
        '| --- | --- | --- | --- | --- | --- | --- |',
        '| `rpy` | tuple[float, float, float] | `(3.14159, 0, -1.5708)` | rad | any | yes | how it is turned |',
        "| `mode` | str | `'a'` |  | 'a' or 'b' |  | either a\\|b |",
    ]


SETTINGS = {node: tuple(classes.values()) for node, classes in SETTINGS_OF_NODES.items()}


def flat(parameters: dict[str, Any], prefix: str = '') -> dict[str, Any]:
    """Name the parameters of a group as ROS does."""
    named: dict[str, Any] = {}
    for name, value in parameters.items():
        named |= flat(value, f'{prefix}{name}.') if isinstance(value, dict) else {prefix + name: value}
    return named


@pytest.mark.parametrize('node', SETTINGS)
def test_parameter_names_are_unique_and_the_example_configuration_holds_their_defaults(node: str) -> None:
    content = yaml.safe_load((ROOT / 'config' / f'{node}.yaml').read_text())
    given = flat(content['/**']['ros__parameters'])
    described = [(d.name, d.default) for cls in SETTINGS[node] for d in describe_settings(cls)]
    known = dict(described)
    assert len(known) == len(described)
    if node == 'pose_arbiter':
        known['sources'] = DEFAULT_SOURCES
        known |= {f'{s}.{d.name}': d.default for s in DEFAULT_SOURCES for d in describe_settings(SourceSettings)}
    if node == 'collision_monitor':
        known['sources'] = RANGE_SOURCES
        known |= {f'{s}.{d.name}': d.default for s in RANGE_SOURCES for d in describe_settings(RangeSourceSettings)}
    for name, value in given.items():
        default = known[name]
        assert (tuple(value) if isinstance(value, list) else value) == default, name


def test_the_nodes_take_what_the_mission_gives_them() -> None:
    for node in mission_nodes(BuildingFiles(ROOT), '/dev/ttyUSB0'):
        taken: set[str] = set()
        for cls in SETTINGS[node.package]:
            names = {description.name for description in describe_settings(cls)} & set(node.parameters)
            settings_from_values(cls, {name: node.parameters[name] for name in names})
            taken |= names
        given = {name: value for name, value in node.parameters.items() if name not in taken}
        for name, value in given.items():
            source, _, field = name.partition('.')
            if source in RANGE_SOURCES:
                settings_from_values(RangeSourceSettings, {field: value})
                taken.add(name)
        assert taken == set(node.parameters)


def test_the_example_beacons_can_be_read() -> None:
    assert [beacon.id for beacon in load_beacons(ROOT / 'config' / 'beacons.yaml')] == [1, 2, 3, 4]
