"""A checkpoint is read back complete or not at all."""

from types import SimpleNamespace

import numpy as np
import pytest

from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.survey_files import checkpoint as checkpoint_module
from floor_localizer.survey_files.checkpoint import Checkpoint

pytestmark = pytest.mark.newest_set_only

SURVEY: dict[str, object] = {'camera': {'fx': 300.0}, 'settings': {'chance_alignments_max': 1e-6}}


def test_a_saved_step_is_loaded(tmp_path):
    Checkpoint(tmp_path, SURVEY).save_step('linked', images=np.arange(3), loops=np.array(2))
    found = Checkpoint(tmp_path, SURVEY).load_step('linked')
    assert found is not None
    assert found['images'].tolist() == [0, 1, 2]
    assert int(found['loops']) == 2
    assert Checkpoint(tmp_path, SURVEY).load_step('adjusted_0') is None


@pytest.mark.parametrize('kept', [0, 1, 100, 400])
def test_a_file_that_was_cut_off_counts_as_none(tmp_path, kept):
    """After a power failure, files may be truncated to any length, often to zero."""
    checkpoint = Checkpoint(tmp_path, SURVEY)
    checkpoint.save_step('linked', images=np.arange(3), loops=np.array(2))
    whole = (tmp_path / 'linked.npz').read_bytes()
    (tmp_path / 'linked.npz').write_bytes(whole[:kept])
    assert checkpoint.load_step('linked') is None


def test_no_damaged_byte_is_an_error(tmp_path):
    checkpoint = Checkpoint(tmp_path, SURVEY)
    checkpoint.save_step('adjusted_0', states=np.arange(6.0))
    whole = (tmp_path / 'adjusted_0.npz').read_bytes()
    for place in range(len(whole)):
        for value in (0x00, 0xFF, whole[place] ^ 0x01, whole[place] ^ 0x20):
            damaged = bytearray(whole)
            damaged[place] = value
            (tmp_path / 'adjusted_0.npz').write_bytes(damaged)
            found = checkpoint.load_step('adjusted_0')
            assert found is None or found['states'].tolist() == list(range(6))


def test_another_survey_is_refused_and_what_is_other_is_named(tmp_path):
    Checkpoint(tmp_path, SURVEY)
    other = {'camera': {'fx': 301.0}, 'settings': {'chance_alignments_max': 1e-5}}
    with pytest.raises(FloorLocalizerError, match='survey, which differs by its camera and settings; remove it'):
        Checkpoint(tmp_path, other)
    (tmp_path / 'survey.json').write_text('')
    with pytest.raises(FloorLocalizerError, match='by its camera and settings and version of the software;'):
        Checkpoint(tmp_path, SURVEY)


def test_what_other_code_has_begun_is_refused(tmp_path, monkeypatch):
    Checkpoint(tmp_path, SURVEY)
    Checkpoint(tmp_path, SURVEY)
    monkeypatch.setattr(checkpoint_module, 'code_version', lambda: 'sources 0123, numpy 9')
    with pytest.raises(FloorLocalizerError, match='by its version of the software; remove it'):
        Checkpoint(tmp_path, SURVEY)


def test_the_version_changes_with_a_source_its_name_and_a_library(tmp_path, monkeypatch):
    source = tmp_path / 'steps' / 'adjustment.py'
    source.parent.mkdir()
    package = SimpleNamespace(__name__='steps', __path__=[str(tmp_path)])
    library = SimpleNamespace(__name__='numpy', __version__='1.26.4')
    monkeypatch.setattr(checkpoint_module, '_PACKAGES', (package,))
    monkeypatch.setattr(checkpoint_module, '_LIBRARIES', (library,))
    source.write_text('_ITERATIONS = 8')
    version = checkpoint_module.code_version
    versions = [version()]
    assert version() == versions[0]
    source.write_text('_ITERATIONS = 9')
    versions.append(version())
    source.rename(source.with_name('rounds.py'))
    versions.append(version())
    library.__version__ = '2.4.6'
    assert len({*versions, version()}) == 4
