"""Results are immutable, and reasons have texts."""

from dataclasses import FrozenInstanceError

import pytest

from floor_localizer.core.fix import NoFix, NoFixReason


def test_every_reason_has_its_own_text():
    texts = [reason.value for reason in NoFixReason]
    assert len(set(texts)) == len(texts)
    assert all(len(text.split()) >= 3 for text in texts)


def test_results_do_not_change():
    result = NoFix(NoFixReason.NO_DOTS, 'none')
    with pytest.raises(FrozenInstanceError):
        result.detail = 'some'
    assert result.dots is None
