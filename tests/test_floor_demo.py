"""The main job on recorded input: the installed node, live, over real Fast DDS, against the true drive."""

import json
from pathlib import Path

import pytest
from node_testing import first_seconds

from shirube_cli.floor_demo import demo_floor
from shirube_cli.project import find_root

pytestmark = pytest.mark.newest_set_only


@pytest.mark.timeout(300)
def test_floor_drive_is_tracked_within_the_limits_and_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    root = find_root()
    beginning = first_seconds(tmp_path / 'bag', 20.0, root / 'bags' / 'floor_drive')
    code = demo_floor(root, tmp_path, beginning)
    said = capsys.readouterr().out
    assert code == 0, said
    accuracy = json.loads((tmp_path / 'accuracy.json').read_text())
    assert accuracy['unmatched'] == 0
    assert 'track.png' in (tmp_path / 'report.html').read_text()
    assert (tmp_path / 'track.png').stat().st_size > 50_000
