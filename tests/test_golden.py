"""Regression test of the nodes: short runs on the committed bags give the committed results.

`./shirube test --renew-goldens` writes the results anew; the reason for it goes into the changelog.
"""

import json
from pathlib import Path
from typing import Any

import cv2
import golden_runs
import numpy as np
import pytest
from golden_comparison import TOLERANCES, compare_poses

pytestmark = [pytest.mark.quick, pytest.mark.timeout(600)]

OLDEST = cv2.__version__.startswith('4.6.')
FOLDER = Path(__file__).parent / 'goldens' / ('oldest' if OLDEST else 'newest')


def golden(name: str, found: Any, *, renew: bool) -> Any:
    """Return the golden result of a run; written anew from what was found if asked for."""
    path = FOLDER / f'{name}.json'
    if renew:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(found, separators=(',', ':')).replace('],[', '],\n[') + '\n')
    return json.loads(path.read_text())


@pytest.fixture(scope='module', params=golden_runs.RUNS)
def run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Any:
    name = request.param
    found = golden_runs.RUNS[name](tmp_path_factory.mktemp(name))
    return name, golden(name, found, renew=request.config.getoption('--renew-goldens')), found


def test_a_run_gives_the_golden_result(run: Any) -> None:
    name, expected, found = run
    if name in TOLERANCES:
        assert found.keys() == expected.keys()
        faults = [
            f'{drive}: {fault}' for drive in found for fault in compare_poses(name, expected[drive], found[drive])
        ]
        assert not faults
    elif name == 'motor_bridge':
        assert found['stops'] == expected['stops']
        # The bridge's thread may send a command one cycle of the controller earlier or later.
        assert np.allclose(found['end'], expected['end'], atol=0.03)
        assert found['odometry_error'] < 2e-3
        assert found['fastest'] == pytest.approx(expected['fastest'], abs=0.03)
    else:
        assert found == expected


def test_a_changed_result_is_noticed(run: Any) -> None:
    name, expected, found = run
    if name not in TOLERANCES:
        pytest.skip('compared value by value')
    for drive, result in found.items():
        far = [[stamp, x + 0.01, *rest] for stamp, x, *rest in result['poses']]
        fewer = result['pose_count'] // 2 - 3
        for change in ({'poses': far}, {'pose_count': fewer}, {'levels': [2, *result['levels']]}):
            if change == {'poses': []} or change.get('pose_count', 0) < 0:
                continue
            assert compare_poses(name, expected[drive], result | change), change
