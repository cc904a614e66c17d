"""How ./shirube finds a Python that can make its environment: with fake ones."""

import subprocess
from pathlib import Path

import pytest

pytestmark = pytest.mark.newest_set_only

ROOT = Path(__file__).resolve().parents[1]


def find_python(home: Path, path: Path, versions: str = '3.12 3.11') -> subprocess.CompletedProcess[str]:
    script = f'source "$1"; find_python "{versions}"'
    return subprocess.run(
        ['/bin/bash', '-c', script, 'bash', str(ROOT / 'environment' / 'ensure.bash')],
        env={'HOME': str(home), 'PATH': str(path)},
        capture_output=True,
        text=True,
        check=False,
    )


def fake_python(path: Path, version: str, *, venv: bool = True, broken: bool = False) -> Path:
    """Write a program that answers as a Python of that version would."""
    path.parent.mkdir(parents=True, exist_ok=True)
    imports = 0 if venv else 1
    answer = f'case "$2" in *version_info*) echo {version};; *) exit {imports};; esac'
    path.write_text(f'#!/bin/bash\n{"exit 127" if broken else answer}\n')
    path.chmod(0o755)
    return path


def test_newest_fitting_python_on_the_path_is_taken(tmp_path: Path) -> None:
    fake_python(tmp_path / 'bin/python3', '3.13')
    fake_python(tmp_path / 'bin/python3.11', '3.11')
    newest = fake_python(tmp_path / 'bin/python3.12', '3.12')
    assert find_python(tmp_path, tmp_path / 'bin').stdout.strip() == str(newest)


def test_broken_shim_is_passed_over_for_the_one_behind_it(tmp_path: Path) -> None:
    fake_python(tmp_path / 'bin/python3.12', '3.12', broken=True)
    fake_python(tmp_path / 'bin/python3.11', '3.11')
    behind = fake_python(tmp_path / '.pyenv/versions/3.12.1/bin/python3', '3.12')
    assert find_python(tmp_path, tmp_path / 'bin').stdout.strip() == str(behind)


@pytest.mark.parametrize(
    ('version', 'venv', 'said'), [('3.13', True, 'found only 3.13'), ('3.12', False, 'apt install python3.12-venv')]
)
def test_unfit_python_is_named_with_the_remedy(tmp_path: Path, version: str, venv: bool, said: str) -> None:
    fake_python(tmp_path / 'bin/python3', version, venv=venv)
    answer = find_python(tmp_path, tmp_path / 'bin')
    assert answer.returncode == 1
    assert said in answer.stderr
    assert len(answer.stderr.splitlines()) == 1


def test_no_python_at_all_is_said(tmp_path: Path) -> None:
    answer = find_python(tmp_path, tmp_path)
    assert answer.returncode == 1
    assert answer.stderr.startswith('shirube: needs Python 3.12 or 3.11, found none')
