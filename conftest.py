"""For all tests."""

_LONGEST_ID = 60


def pytest_make_parametrize_id(val: object) -> str | None:
    """Name a long value by its beginning; pytest numbers those that begin alike."""
    if not isinstance(val, str | bytes | int):
        return None
    written = hex(val) if isinstance(val, int) else ascii(val)[1:-1]
    return f'{written[:_LONGEST_ID]}...' if len(written) > _LONGEST_ID else None
