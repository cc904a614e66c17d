"""Parameter files get present names, and nothing else of them changes."""

from pathlib import Path

import pytest
import yaml

from shirube_cli.main import main
from shirube_cli.migrate import former_names, former_names_in, migrate, rename_parameters, widen_root
from shirube_cli.project import CommandError
from shirube_cli.settings_of_nodes import SETTINGS_OF_NODES
from shirube_core.settings import describe_settings

ROOT = Path(__file__).resolve().parents[3]
OLD = """\
# my robot
pose_arbiter:
  ros__parameters:
    slack_xy: 0.01  # way_noise: in a comment stays
    'lasting_way': 2.0
vlc_beacon:
  ros__parameters:
    odometry:
      gap_way: 0.3
    odometry.lasting_way: 1.0
    speed_limit: 0.4
other_node:
  ros__parameters:
    slack_xy: 5.0
"""
NEW = (
    OLD.replace('slack_xy: 0.01', 'gate_margin_xy: 0.01')
    .replace('lasting_way', 'bias_correlation_length')
    .replace('gap_way', 'gap_distance_max')
)


def test_only_former_names_of_the_right_node_change() -> None:
    assert rename_parameters(OLD) == NEW
    assert rename_parameters(NEW) == NEW
    assert set(former_names_in(yaml.safe_load(OLD))) == {
        'slack_xy', 'lasting_way', 'odometry.gap_way', 'odometry.lasting_way',
    }  # fmt: skip


@pytest.mark.parametrize('node', ['/**', '/robot_1/pose_arbiter', '/*'])
def test_wildcards_and_namespaces_are_understood(node: str) -> None:
    text = f'{node}:\n  ros__parameters:\n    way_noise: 0.1\n'
    assert rename_parameters(text) == text.replace('way_noise', 'odometry_noise_xy')


def test_the_root_of_a_file_for_one_node_becomes_that_of_any_namespace() -> None:
    text = '# motor_bridge:\n{}:\n  ros__parameters:\n    wheel_radius: 0.05 # motor_bridge:\n'
    for root in ('motor_bridge', '/motor_bridge', "'motor_bridge'"):
        assert widen_root(text.format(root)) == text.format('/**')
    assert [*yaml.safe_load(widen_root(OLD))] == ['/**/pose_arbiter', '/**/vlc_beacon', 'other_node']
    for other in (text.format('/robot1/motor_bridge'), text.format('/**'), text.format('driver'), '[1]'):
        assert widen_root(other) == other


def test_a_former_name_is_nobodys_present_name() -> None:
    for node, classes in SETTINGS_OF_NODES.items():
        names = {description.name for cls in classes.values() for description in describe_settings(cls)}
        assert not names & former_names(node).keys()


def test_the_command_rewrites_and_repeats_without_a_change(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / 'robot.yaml'
    path.write_text(OLD)
    assert migrate(['--dry-run', str(path)]) == 0
    assert path.read_text() == OLD
    assert migrate([str(path)]) == 0
    assert path.read_text() == widen_root(NEW)
    assert '+    gate_margin_xy: 0.01' in capsys.readouterr().out
    assert migrate([str(path)]) == 0
    assert capsys.readouterr().out == f'{path}: nothing to change\n'


def test_committed_files_need_no_change(capsys: pytest.CaptureFixture[str]) -> None:
    files = [*ROOT.glob('config/*.yaml'), ROOT / 'bags/corridor_teach/lesson.yaml']
    assert migrate(['--dry-run', *map(str, files)]) == 0
    assert capsys.readouterr().out.count('nothing to change') == len(files)


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('pose_arbiter: {ros__parameters: {slack_xy: 0.1}}\n', 'rename slack_xy by hand'),
        ('a: [\n', 'robot.yaml'),
        (None, 'robot.yaml'),
    ],
)
def test_bad_files_are_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str | None, words: str
) -> None:
    path = tmp_path / 'robot.yaml'
    if text is not None:
        path.write_text(text)
    with pytest.raises(CommandError, match=words):
        migrate([str(path)])
    assert main(['migrate', str(path)]) == 1
    assert capsys.readouterr().err.count('\n') == 1
