"""What a survey wrote down: found again whole, or not at all."""

from pathlib import Path

import numpy as np
import pytest

from floor_localizer.survey_files.checkpoint import Checkpoint

pytestmark = pytest.mark.newest_set_only

SURVEY: dict[str, object] = {'camera': {'fx': 300.0}, 'settings': {'chance': 1e-6}}


def test_what_was_kept_is_recalled(tmp_path: Path) -> None:
    Checkpoint(tmp_path, SURVEY).keep('linked', images=np.arange(3), loops=np.array(2))
    found = Checkpoint(tmp_path, SURVEY).recall('linked')
    assert found is not None
    assert found['images'].tolist() == [0, 1, 2]
    assert int(found['loops']) == 2
    assert Checkpoint(tmp_path, SURVEY).recall('adjusted_0') is None


@pytest.mark.parametrize('kept', [0, 1, 100, 400])
def test_a_file_that_was_cut_off_counts_as_none(tmp_path: Path, kept: int) -> None:
    """A computer that loses its power leaves files of any length, above all of none."""
    checkpoint = Checkpoint(tmp_path, SURVEY)
    checkpoint.keep('linked', images=np.arange(3), loops=np.array(2))
    whole = (tmp_path / 'linked.npz').read_bytes()
    (tmp_path / 'linked.npz').write_bytes(whole[:kept])
    assert checkpoint.recall('linked') is None


def test_no_damaged_byte_is_an_error(tmp_path: Path) -> None:
    checkpoint = Checkpoint(tmp_path, SURVEY)
    checkpoint.keep('adjusted_0', states=np.arange(6.0))
    whole = (tmp_path / 'adjusted_0.npz').read_bytes()
    for place in range(len(whole)):
        for value in (0x00, 0xFF, whole[place] ^ 0x01, whole[place] ^ 0x20):
            damaged = bytearray(whole)
            damaged[place] = value
            (tmp_path / 'adjusted_0.npz').write_bytes(damaged)
            found = checkpoint.recall('adjusted_0')
            assert found is None or found['states'].tolist() == list(range(6))
