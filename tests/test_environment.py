"""How the door finds Python and makes the environment: with stand-ins for Python, and without a network."""

import importlib.util
import subprocess
from pathlib import Path
from types import ModuleType

import pytest

pytestmark = pytest.mark.newest_set_only

ROOT = Path(__file__).resolve().parents[1]
PIP_CALL = 'pip is not called here'


def find_python(home: Path, path: Path, versions: str = '3.12 3.11') -> subprocess.CompletedProcess[str]:
    script = f'source "$1"; find_python "{versions}"'
    return subprocess.run(
        ['/bin/bash', '-c', script, 'bash', str(ROOT / 'environment' / 'ensure.bash')],
        env={'HOME': str(home), 'PATH': str(path)},
        capture_output=True,
        text=True,
        check=False,
    )


def stand_in(path: Path, version: str, *, venv: bool = True, broken: bool = False) -> Path:
    """Write a program that answers the door's two questions as a Python of that version would."""
    path.parent.mkdir(parents=True, exist_ok=True)
    imports = 0 if venv else 1
    answer = (
        'exit 127' if broken else f'case "$2" in *version_info*) echo {version};; *) exit {imports};; esac'
    )
    path.write_text(f'#!/bin/bash\n{answer}\n')
    path.chmod(0o755)
    return path


def test_newest_fitting_python_on_the_path_is_taken(tmp_path: Path) -> None:
    stand_in(tmp_path / 'bin/python3', '3.13')
    stand_in(tmp_path / 'bin/python3.11', '3.11')
    newest = stand_in(tmp_path / 'bin/python3.12', '3.12')
    assert find_python(tmp_path, tmp_path / 'bin').stdout.strip() == str(newest)


def test_broken_shim_is_passed_over_for_the_one_behind_it(tmp_path: Path) -> None:
    stand_in(tmp_path / 'bin/python3.12', '3.12', broken=True)
    stand_in(tmp_path / 'bin/python3.11', '3.11')
    behind = stand_in(tmp_path / '.pyenv/versions/3.12.1/bin/python3', '3.12')
    assert find_python(tmp_path, tmp_path / 'bin').stdout.strip() == str(behind)


@pytest.mark.parametrize(
    ('version', 'venv', 'said'),
    [('3.13', True, 'found only 3.13'), ('3.12', False, 'apt install python3.12-venv')],
)
def test_unfit_python_is_named_with_the_remedy(tmp_path: Path, version: str, venv: bool, said: str) -> None:
    stand_in(tmp_path / 'bin/python3', version, venv=venv)
    answer = find_python(tmp_path, tmp_path / 'bin')
    assert answer.returncode == 1
    assert said in answer.stderr
    assert len(answer.stderr.splitlines()) == 1


def test_no_python_at_all_is_said(tmp_path: Path) -> None:
    answer = find_python(tmp_path, tmp_path)
    assert answer.returncode == 1
    assert answer.stderr.startswith('shirube: needs Python 3.12 or 3.11, found none')


@pytest.fixture
def install() -> ModuleType:
    spec = importlib.util.spec_from_file_location('install', ROOT / 'environment' / 'install.py')
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_unfinished_installation_is_done_again_and_a_finished_one_is_kept(
    install: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, calls = tmp_path / 'venv', []

    def failing_pip(*_: object) -> None:
        raise install.InstallError(PIP_CALL)

    def quick_venv(command: list[str], **options: object) -> object:
        return run([*command, '--without-pip'] if 'venv' in command else command, **options)

    run = subprocess.run
    monkeypatch.setattr(install.subprocess, 'run', quick_venv)
    monkeypatch.setattr(install, 'run', failing_pip)
    assert install.main([str(folder), 'locks', 'project', 'dev.lock']) == 1
    assert PIP_CALL in capsys.readouterr().err
    (folder / 'left over').touch()

    def quick_run(folder: Path, arguments: list[str], _variables: dict[str, str] | None = None) -> None:
        calls.append(arguments)
        (folder / 'bin/uv').touch()

    monkeypatch.setattr(install, 'run', quick_run)
    assert install.main([str(folder), 'locks', 'project', 'dev.lock']) == 0
    assert len(calls) == 3
    assert not (folder / 'left over').exists()

    assert install.main([str(folder), 'locks', 'project', 'dev.lock']) == 0
    assert len(calls) == 3
    assert install.main([str(folder), 'locks', 'changed project', 'dev.lock']) == 0
    assert [arguments[-2:] for arguments in calls[3:]] == [['--editable', str(ROOT)]]


def test_what_pip_is_told_about_sources_is_handed_on(install: ModuleType, tmp_path: Path) -> None:
    python = tmp_path / 'bin/python'
    python.parent.mkdir()
    listed = """:env:.index-url='https://mirror/simple'
global.cert='/etc/own.pem'
global.extra-index-url='https://one https://two'
global.index-url='https://outdone'
global.timeout='60'"""
    python.write_text(f'#!/bin/bash\ncat <<"E"\n{listed}\nE\n')
    python.chmod(0o755)
    options, variables = install.pip_settings(tmp_path)
    sources = [
        '--index-url',
        'https://mirror/simple',
        '--extra-index-url',
        'https://one',
        '--extra-index-url',
        'https://two',
    ]
    assert options == sources
    assert variables == {'SSL_CERT_FILE': '/etc/own.pem'}


def test_environment_of_somebody_else_is_left_alone(
    install: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / 'precious').touch()
    assert install.main([str(tmp_path), 'locks', 'project', 'dev.lock']) == 1
    assert 'move it away' in capsys.readouterr().err
    assert (tmp_path / 'precious').exists()
