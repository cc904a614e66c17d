"""The notebooks run as they are written, and the API reference is current."""

import json
import runpy
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest

pytestmark = pytest.mark.newest_set_only

DOCS = Path(__file__).resolve().parents[1] / 'docs'
NOTEBOOKS = sorted((DOCS / 'notebooks').glob('*.ipynb'))


def test_each_method_has_a_small_notebook() -> None:
    assert [path.stem for path in NOTEBOOKS] == ['floor', 'fuse', 'lamps', 'plan', 'stereo']
    assert max(path.stat().st_size for path in NOTEBOOKS) < 80_000


@pytest.mark.parametrize('path', NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_prints_what_it_shows(
    path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(path.parent)
    mpl.use('Agg')
    names: dict[str, object] = {'__name__': '__main__'}
    for cell in json.loads(path.read_text())['cells']:
        if cell['cell_type'] == 'code':
            exec(compile(''.join(cell['source']), path.name, 'exec'), names)
            shown = [line for output in cell['outputs'] for line in output.get('text', ())]
            assert bool(capsys.readouterr().out) == bool(shown)
            assert bool(plt.get_fignums()) == any('data' in output for output in cell['outputs'])
            plt.close('all')


def test_api_reference_is_current() -> None:
    written = runpy.run_path(str(DOCS / 'write_api.py'))
    assert (DOCS / 'api.md').read_text() == written['api_page'](), 'run docs/write_api.py'
