"""Which demo is run, and that its exit code is handed on."""

import pytest

from shirube_cli import demo, floor_demo
from shirube_cli.project import CommandError


@pytest.mark.parametrize(
    ('arguments', 'wanted', 'code'), [([], 'mission', 0), (['mission'], 'mission', 1), (['floor'], 'floor', 1)]
)
def test_the_mission_is_the_demo_unless_the_floor_is_asked_for(arguments, wanted, code, monkeypatch, tmp_path):
    ran = []

    def stand_in(name):
        return lambda root, folder, *planner: ran.append((name, root, folder, *planner)) or code

    monkeypatch.setattr(demo, 'find_home', lambda: tmp_path)
    (tmp_path / 'ros2_ws').mkdir()
    monkeypatch.setattr(demo, 'build_workspace', lambda root, sets: None)
    monkeypatch.setattr(demo, 'demo_mission', stand_in('mission'))
    monkeypatch.setattr(floor_demo, 'demo_floor', stand_in('floor'))
    (tmp_path / 'out' / 'demo').mkdir(parents=True)
    (tmp_path / 'out' / 'demo' / 'report.html').write_text('of an earlier run')
    assert demo.demo(arguments) == code
    assert ran == [(wanted, tmp_path, tmp_path / 'out' / 'demo')]
    assert list((tmp_path / 'out' / 'demo').iterdir()) == []


def test_the_planner_is_handed_on_to_the_mission_only(monkeypatch, tmp_path):
    ran = []
    monkeypatch.setattr(demo, 'find_home', lambda: tmp_path)
    (tmp_path / 'ros2_ws').mkdir()
    monkeypatch.setattr(demo, 'build_workspace', lambda root, sets: None)
    monkeypatch.setattr(demo, 'demo_mission', lambda root, folder, planner: ran.append(planner) or 0)
    assert demo.demo(['mission', '--planner', 'paper']) == 0
    assert ran == ['paper']
    with pytest.raises(CommandError, match='an option of the mission'):
        demo.demo(['floor', '--planner', 'paper'])
