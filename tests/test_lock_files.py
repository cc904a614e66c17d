"""The lock files hold every dependency with its hashes, and no address; set-up prints ASCII only."""

import re
import tomllib
from pathlib import Path

import pytest

pytestmark = pytest.mark.newest_set_only

ROOT = Path(__file__).resolve().parents[1]
ENVIRONMENT = ROOT / 'environment'
LOCKS = {path.stem: path.read_text() for path in ENVIRONMENT.glob('*.lock')}


def locked_versions(name: str) -> dict[str, str]:
    """Return the version of each package in a lock file."""
    return dict(re.findall(r'^([\w.-]+)==([^\s;]+)', LOCKS[name], re.MULTILINE))


@pytest.mark.parametrize('name', LOCKS)
def test_every_locked_package_has_hashes_and_no_address(name: str) -> None:
    entries = re.split(r'^(?=[^\s#])', LOCKS[name], flags=re.MULTILINE)[1:]
    assert len(entries) == len(locked_versions(name)) > 1
    for entry in entries:
        assert re.match(r'[\w.-]+==\S+ .*\\\n    --hash=sha256:[0-9a-f]{64}', entry), entry.splitlines()[0]
        rest = re.sub(r' \\$| {4}--hash=sha256:[0-9a-f]{64}( \\)?$', '', entry, flags=re.MULTILINE)
        assert len(rest.split('\n', 1)[1].strip()) == 0, rest
    assert '//' not in LOCKS[name]


def test_every_dependency_is_locked_as_it_is_asked_for() -> None:
    project = tomllib.loads((ROOT / 'pyproject.toml').read_text())['project']
    extras = project['optional-dependencies']
    runtime = set(locked_versions('runtime'))
    assert format_names([*project['dependencies'], *extras['workspace']]) <= runtime
    development = format_names([*extras['cluster'], *extras['test'], *extras['check'], *extras['bench']])
    assert development <= runtime | set(locked_versions('dev'))
    assert not runtime & set(locked_versions('dev'))
    oldest = locked_versions('oldest')
    assert format_names([*project['dependencies'], *extras['workspace'], *extras['test']]) <= set(oldest)
    assert {f'{name}=={oldest[name]}' for name in format_names(extras['oldest'])} == set(extras['oldest'])
    assert locked_versions('installer')['setuptools'] == locked_versions('runtime')['setuptools']


def format_names(requirements: list[str]) -> set[str]:
    """Return the names of packages as lock files spell them."""
    return {re.split(r'[<>=\[]', one)[0].lower().replace('_', '-') for one in requirements}


def test_what_the_installation_prints_is_ascii() -> None:
    for path in (ROOT / 'shirube', *ENVIRONMENT.iterdir()):
        if path.is_file():
            assert path.read_text().isascii(), path.name
