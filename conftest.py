"""For all tests."""

import pytest

_LONGEST_ID = 60


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that writes the golden results anew."""
    parser.addoption('--renew-goldens', action='store_true', help='write tests/goldens from this run')


def pytest_make_parametrize_id(val: object) -> str | None:
    """Name a long value by its beginning; pytest numbers those that begin alike."""
    if not isinstance(val, str | bytes | int):
        return None
    written = hex(val) if isinstance(val, int) else ascii(val)[1:-1]
    return f'{written[:_LONGEST_ID]}...' if len(written) > _LONGEST_ID else None
