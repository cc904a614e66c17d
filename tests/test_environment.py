"""How the environment is made and repaired: with fake installers, without a network."""

import errno
import fcntl
import importlib
import os
import re
import subprocess
import sys
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

pytestmark = pytest.mark.newest_set_only

ROOT = Path(__file__).resolve().parents[1]
ENVIRONMENT = ROOT / 'environment'


@pytest.fixture
def install(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.setattr(sys, 'path', [str(ENVIRONMENT), *sys.path])
    return importlib.import_module('install')


@dataclass
class FakeInstallers:
    """In place of venv, pip and uv: makes a Python that runs, and notes what would be installed.

    Attributes:
        calls: what was started, with its arguments.
        killed_at: number of the call at which everything ends as if by SIGKILL.
    """

    calls: list[tuple[str, list[str]]] = field(default_factory=list)
    killed_at: int | None = None

    def run(self, environment: Any, name: str, command: list[str]) -> None:
        if len(self.calls) == self.killed_at:
            self.killed_at = None
            (environment.folder / 'left over').touch()
            raise Killed
        self.calls.append((name, command))
        if name == 'python -m venv':
            (environment.folder / 'bin').mkdir()
            (environment.folder / 'bin/python').symlink_to(sys.executable)

    def names(self) -> list[str]:
        return [name for name, _ in self.calls]


class Killed(BaseException):
    """Nothing catches this, as nothing catches SIGKILL."""


@pytest.fixture
def installers(install: ModuleType, monkeypatch: pytest.MonkeyPatch) -> FakeInstallers:
    fake = FakeInstallers()

    def run(environment: Any, name: str, command: list[str], _variables: object = None) -> None:
        fake.run(environment, name, command)

    monkeypatch.setattr(install.Environment, 'run', run)
    monkeypatch.setattr(install, 'pip_settings', lambda _: {})
    return fake


ALL = ['python -m venv', 'pip', 'uv', 'uv']


def test_complete_environment_is_kept_and_only_what_is_missing_is_added(
    install: ModuleType, installers: FakeInstallers, tmp_path: Path
) -> None:
    folder = str(tmp_path / 'venv')
    assert install.main([folder, 'project', 'runtime.lock']) == 0
    assert installers.names() == ALL
    assert '--require-hashes' in installers.calls[1][1]
    assert '--require-hashes' in installers.calls[2][1]
    assert install.main([folder, 'project', 'runtime.lock']) == 0
    assert installers.names() == ALL

    kept = tmp_path / 'venv/kept'
    kept.touch()
    assert install.main([folder, 'project', 'runtime.lock', 'dev.lock']) == 0
    assert installers.names() == [*ALL, 'uv']
    assert installers.calls[-1][1][-2:] == ['--requirement', str(ENVIRONMENT / 'dev.lock')]
    assert install.main([folder, 'project', 'runtime.lock']) == 0
    assert install.main([folder, 'changed project', 'runtime.lock', 'dev.lock']) == 0
    assert installers.names() == [*ALL, 'uv', 'uv']
    assert installers.calls[-1][1][-2:] == ['--editable', str(ROOT)]
    assert kept.exists()


def test_environment_of_other_locks_is_made_again(
    install: ModuleType, installers: FakeInstallers, tmp_path: Path
) -> None:
    folder = tmp_path / 'venv'
    assert install.main([str(folder), 'project', 'runtime.lock']) == 0
    (folder / 'left over').touch()
    stamp = folder / 'shirube.stamp'
    stamp.write_text(re.sub(r'\w{8}  runtime', '00000000  runtime', stamp.read_text()))
    assert install.main([str(folder), 'project', 'runtime.lock']) == 0
    assert installers.names() == [*ALL, *ALL]
    assert not (folder / 'left over').exists()


@pytest.mark.parametrize('call', range(len(ALL)))
def test_after_a_kill_at_any_stage_the_next_call_completes_the_environment(
    install: ModuleType, installers: FakeInstallers, tmp_path: Path, call: int
) -> None:
    folder, installers.killed_at = tmp_path / 'venv', call
    with pytest.raises(Killed):
        install.main([str(folder), 'project', 'runtime.lock'])
    assert install.main([str(folder), 'project', 'runtime.lock']) == 0
    assert installers.names()[-1:] == ['uv']
    # What was half installed is not trusted; the project alone is installed again where it was.
    assert (folder / 'left over').exists() == (ALL[call:] == ['uv'])
    done = len(installers.calls)
    assert install.main([str(folder), 'project', 'runtime.lock']) == 0
    assert len(installers.calls) == done


def test_after_a_kill_while_packages_were_added_the_environment_is_made_again(
    install: ModuleType, installers: FakeInstallers, tmp_path: Path
) -> None:
    arguments = [str(tmp_path / 'venv'), 'project', 'runtime.lock']
    assert install.main(arguments) == 0
    installers.killed_at = len(ALL)
    with pytest.raises(Killed):
        install.main([*arguments, 'dev.lock'])
    assert install.main(arguments) == 0
    assert installers.names() == [*ALL, *ALL]


def test_what_a_killed_removal_left_is_removed(install: ModuleType, installers: FakeInstallers, tmp_path: Path) -> None:
    for name in ('venv.old', 'venv.new'):
        (tmp_path / name / 'bin').mkdir(parents=True)
    assert install.main([str(tmp_path / 'venv'), 'project', 'runtime.lock']) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ['venv', 'venv.lock']


def test_killed_installer_is_named(install: ModuleType, tmp_path: Path) -> None:
    with ExitStack() as stack:
        environment = install.Environment(tmp_path / 'venv', stack)
        with pytest.raises(install.InstallError, match=r'^uv was ended by SIGKILL; the next call'):
            environment.run('uv', ['/bin/bash', '-c', 'kill -KILL $$'])


def test_installer_that_outlives_its_parent_keeps_the_lock(install: ModuleType, tmp_path: Path) -> None:
    with ExitStack() as stack:
        environment = install.Environment(tmp_path / 'venv', stack)
        orphan = subprocess.Popen(['sleep', '60'], pass_fds=environment.locks)
    with (tmp_path / 'venv.lock').open('w') as lock:
        with pytest.raises(BlockingIOError):
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        orphan.kill()
        orphan.wait()
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)


@pytest.mark.parametrize(
    ('code', 'output', 'said'),
    [
        (1, 'error: Failed to install: x\n  cause: No space left on device', 'the disk is full'),
        (2, 'error: Request failed\n  cause: Failed to fetch: x\n  cause: dns error', 'check the network'),
        (1, 'ERROR: Could not find a version that satisfies the requirement uv', 'check the network'),
        (1, 'error: Failed to download `x`\n  cause: Hash mismatch for `x`', 'not the locked one'),
        (1, 'Error: \u2026', 'failed (Error: ?)'),
        (3, '', 'failed (without a message)'),
        (-9, 'Downloading x', 'ended by SIGKILL'),
    ],
)
def test_failed_installer_is_one_line_with_the_remedy(
    install: ModuleType, code: int, output: str, said: str, tmp_path: Path
) -> None:
    message = install.explain_failure('uv', code, output.splitlines(), tmp_path)
    assert said in message
    assert ';' in message
    assert message.isascii()
    assert len(message.splitlines()) == 1


@pytest.mark.parametrize(
    ('number', 'said'),
    [(errno.ENOSPC, 'the disk is full'), (errno.EROFS, 'copy the repository'), (errno.EACCES, 'cp -r')],
)
def test_refusal_of_the_disk_is_one_line_with_the_remedy(
    install: ModuleType,
    installers: FakeInstallers,
    number: int,
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(number, os.strerror(number), str(tmp_path / 'file'))

    with monkeypatch.context() as patched:
        patched.setattr(install, 'write_stamp', refuse)
        assert install.main([str(tmp_path / 'venv'), 'project', 'runtime.lock']) == 1
    last = capsys.readouterr().err.splitlines()[-1]
    assert last.startswith('shirube: ')
    assert said in last
    assert install.main([str(tmp_path / 'venv'), 'project', 'runtime.lock']) == 0


def test_settings_of_pip_are_passed_to_uv_and_missing_folders_are_not(install: ModuleType, tmp_path: Path) -> None:
    python = tmp_path / 'python'
    listed = f""":env:.index-url='https://mirror/simple'
global.cert='/etc/own.pem'
global.extra-index-url='https://one file://{tmp_path} file:///nowhere/simple'
global.find-links='/nowhere/wheels'
global.index-url='https://outdone'
global.timeout='60'"""
    python.write_text(f'#!/bin/bash\ncat <<"E"\n{listed}\nE\n')
    python.chmod(0o755)
    settings = install.pip_settings(str(python))
    options = ['--index-url', 'https://mirror/simple', '--extra-index-url', 'https://one']
    assert install.source_options(settings) == [*options, '--extra-index-url', f'file://{tmp_path}']
    assert install.source_variables(settings) == {'SSL_CERT_FILE': '/etc/own.pem'}


@pytest.mark.parametrize('is_link', [False, True])
def test_environment_of_somebody_else_is_left_alone(
    install: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str], is_link: bool
) -> None:
    theirs, folder = tmp_path / 'theirs', tmp_path / 'venv'
    (theirs if is_link else folder).mkdir()
    if is_link:
        folder.symlink_to(theirs)
    (folder / 'precious').touch()
    assert install.main([str(folder), 'project', 'dev.lock']) == 1
    assert 'move it away' in capsys.readouterr().err
    assert (folder / 'precious').exists()
