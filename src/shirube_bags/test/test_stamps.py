"""Stamps are converted to text without loss."""

import pytest

from shirube_bags.stamps import stamp_from_text, text_from_stamp


@pytest.mark.parametrize('stamp_ns', [0, 1, 999_999_999, 10**9, 1_700_000_000_123_456_789, 2**63 - 10**9])
def test_a_stamp_is_the_same_after_its_text(stamp_ns):
    assert stamp_from_text(text_from_stamp(stamp_ns)) == stamp_ns


@pytest.mark.parametrize(('text', 'stamp_ns'), [('1.5', 1_500_000_000), ('1.7e9', 17 * 10**17), ('-0.1', -(10**8))])
def test_usual_forms_are_understood(text, stamp_ns):
    assert stamp_from_text(text) == stamp_ns


@pytest.mark.parametrize('text', ['', 'x', 'nan', 'inf', '-inf', '1e300'])
def test_what_is_no_time_is_refused(text):
    with pytest.raises(ValueError, match='no time in seconds'):
        stamp_from_text(text)
