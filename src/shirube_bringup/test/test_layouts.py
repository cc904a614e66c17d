"""RViz's and Foxglove's layouts show the topics that the nodes publish."""

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

PACKAGE = Path(__file__).resolve().parents[1]


def strings_in(value: object) -> Iterator[str]:
    """Yield every key and every text of a file that was read."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for key, inner in value.items():
            yield from strings_in(key)
            yield from strings_in(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from strings_in(inner)


NODES = ('floor_localizer', 'stereo_landmark', 'vlc_beacon', 'reward_planner', 'pose_arbiter')


@pytest.mark.parametrize('path', ['rviz/shirube.rviz', 'foxglove/shirube.json'])
def test_shown_topics_are_published_by_the_nodes(path: str) -> None:
    text = (PACKAGE / path).read_text()
    read = json.loads(text) if path.endswith('json') else yaml.safe_load(text)
    shown = {s for s in strings_in(read) if re.match(rf'/({"|".join(NODES)})/', s)}
    assert {topic.split('/')[1] for topic in shown} == set(NODES)
    for topic in shown - {s for s in shown if s.endswith('_updates')}:
        package, name = topic.split('/')[1:3]
        source = ''.join(p.read_text() for p in (PACKAGE.parent / package / package).rglob('*.py'))
        assert f"'~/{name}'" in source, topic


def test_the_foxglove_layout_shows_every_topic_of_the_nodes() -> None:
    layout = json.loads((PACKAGE / 'foxglove' / 'shirube.json').read_text())
    shown = {re.split(r'[.\[]', text)[0] for text in strings_in(layout['configById'])}
    wanted = {'/cmd_vel', '/estop', '/odom', '/joint_states', '/diagnostics', '/goal_pose', '/initialpose'}
    for node in NODES:
        for source in (PACKAGE.parent / node / node).glob('*.py'):
            matches = re.findall(r"(?:create_publisher|MapPublisher)\(\s*\S+, '~/(\w+)'", source.read_text())
            owner = source.stem.removesuffix('_node') if source.stem.endswith('_node') else node
            wanted |= {f'/{owner}/{name}' for name in matches if name != 'cmd_vel'}
    assert len(wanted) > 20
    assert wanted <= shown
    panels = set(strings_in(layout['layout']))
    assert set(layout['configById']) <= panels
