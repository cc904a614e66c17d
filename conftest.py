"""For all tests."""

import os
from pathlib import Path

import pytest

_DATA = Path(__file__).resolve().parents[1] / 'shared' / 'data'
# Tests on real recordings run where these are: in the folder that SHIRUBE_DATA names, or next to the checkout.
if 'SHIRUBE_DATA' not in os.environ and _DATA.is_dir():
    os.environ['SHIRUBE_DATA'] = str(_DATA)

_LONGEST_ID = 60


def pytest_addoption(parser: pytest.Parser, pluginmanager: pytest.PytestPluginManager) -> None:
    """Add the option that writes the golden results anew."""
    parser.addoption('--renew-goldens', action='store_true', help='write tests/goldens from this run')
    if not pluginmanager.has_plugin('timeout'):  # "colcon test" on a robot
        parser.addini('timeout', 'limit of a test [s], with pytest-timeout')


def pytest_configure(config: pytest.Config) -> None:
    """Let tests with a time limit run without pytest-timeout."""
    if not config.pluginmanager.has_plugin('timeout'):
        config.addinivalue_line('markers', 'timeout(seconds): limit of a test, with pytest-timeout')


def pytest_make_parametrize_id(val: object) -> str | None:
    """Name a long value by its beginning; pytest numbers those that begin alike."""
    if not isinstance(val, str | bytes | int):
        return None
    written = hex(val) if isinstance(val, int) else ascii(val)[1:-1]
    return f'{written[:_LONGEST_ID]}...' if len(written) > _LONGEST_ID else None
