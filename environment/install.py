"""Makes one of the project's virtual environments from its lock files; standard library only.

Called by ensure.bash. The stamp is written last, so that an installation that was cut off is seen as such
and done again.
"""

import fcntl
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ENVIRONMENT = Path(__file__).resolve().parent
ROOT = ENVIRONMENT.parent
MARK = 'shirube.mark'
STAMP = 'shirube.stamp'
VERSION = sys.version.split()[0]
INSTALLER = 'uv==0.13.9'
SOURCES = {
    'index-url': '--index-url',
    'extra-index-url': '--extra-index-url',
    'find-links': '--find-links',
    'trusted-host': '--allow-insecure-host',
}
"""Where packages come from: pip's setting and uv's option."""


def main(arguments: list[str]) -> int:
    """Makes or completes an environment: FOLDER LOCKS_DIGEST PROJECT_DIGEST LOCK..."""
    folder, locks_digest, project_digest = Path(arguments[0]), arguments[1], arguments[2]
    locks = [ENVIRONMENT / name for name in arguments[3:]]
    wanted = [f'{locks_digest} {VERSION} {ROOT}', project_digest]
    try:
        # Two terminals may start at once: the second waits here and then finds everything done.
        with locked(folder.with_name(f'{folder.name}.lock')):
            complete(folder, locks, wanted)
    except InstallError as error:
        print(f'shirube: {error}', file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print('\nshirube: stopped; the next call starts the installation again', file=sys.stderr)
        return 130
    return 0


def complete(folder: Path, locks: list[Path], wanted: list[str]) -> None:
    """Installs what the environment lacks."""
    present = read_stamp(folder) if python_works(folder) else []
    if present == wanted:
        return
    if present[:1] != wanted[:1]:
        make_environment(folder, locks)
    write_stamp(folder, [wanted[0], 'project not installed yet'])
    # The project's own metadata lies beside its sources: one environment after the other.
    with locked(ENVIRONMENT.parent / '.venv-project.lock'):
        install_packages(folder, ['--no-build-isolation', '--editable', str(ROOT)])
    write_stamp(folder, wanted)


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Makes a second process wait that comes here at the same time."""
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


class InstallError(RuntimeError):
    """The environment could not be made; the message is one line with the remedy."""


def make_environment(folder: Path, locks: list[Path]) -> None:
    """Makes the environment from nothing, in place of one that is outdated or unfinished."""
    if folder.exists() and not (folder / MARK).exists():
        raise InstallError(f'{folder} exists but was not made by shirube; move it away and try again')
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    (folder / MARK).touch()
    print(f'Making {folder} with Python {VERSION} (once, about a minute) …', file=sys.stderr)
    made = subprocess.run(
        [sys.executable, '-m', 'venv', str(folder)], capture_output=True, text=True, check=False
    )
    if made.returncode:
        raise InstallError(f'python -m venv {folder} failed: {last_line(made.stdout + made.stderr)}')
    requirements = [word for lock in locks for word in ('--requirement', str(lock))]
    install_packages(folder, requirements)


def install_packages(folder: Path, arguments: list[str]) -> None:
    """Lets uv put packages into the environment, which is much quicker than pip; it shows how far it is."""
    if not (folder / 'bin/uv').exists():
        run(folder, ['-m', 'pip', 'install', '--quiet', '--no-deps', '--no-input', INSTALLER])
    options, variables = pip_settings(folder)
    chosen = ['--no-deps', '--index-strategy', 'unsafe-best-match', *options, *arguments]
    run(folder, ['-m', 'uv', 'pip', 'install', '--python', str(folder / 'bin/python'), *chosen], variables)


def run(folder: Path, arguments: list[str], variables: dict[str, str] | None = None) -> None:
    """Runs the environment's Python and shows what it says, but not the list of all that was installed."""
    command = [str(folder / 'bin/python'), *arguments]
    with subprocess.Popen(
        command,
        env={**os.environ, **(variables or {})},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as program:
        try:
            for line in program.stdout or ():
                if not line.startswith(' + '):
                    print(line, end='', file=sys.stderr, flush=True)
        except BaseException:
            program.terminate()
            raise
    if program.returncode:
        raise InstallError(
            f'{arguments[1]} could not install the packages (is the network there?), see above'
        )


def pip_settings(folder: Path) -> tuple[list[str], dict[str, str]]:
    """Returns what pip is told about sources, as options and variables of uv, which does not read its settings."""
    command = [str(folder / 'bin/python'), '-m', 'pip', 'config', 'list']
    listed = subprocess.run(command, capture_output=True, text=True, check=False).stdout
    settings: dict[str, str] = {}
    # pip lists them by the alphabet; a variable of the environment outdoes the files.
    for line in sorted(listed.splitlines(), key=lambda line: line.startswith(':env:')):
        name, _, value = line.partition('=')
        settings[name.rpartition('.')[2]] = value.strip("'")
    options = [
        word
        for name in SOURCES
        for place in settings.get(name, '').split()
        for word in (SOURCES[name], place)
    ]
    return options, {'SSL_CERT_FILE': settings['cert']} if 'cert' in settings else {}


def python_works(folder: Path) -> bool:
    """Tells whether the environment's Python runs; it does not once the Python it was made from is gone."""
    python = folder / 'bin/python'
    return python.exists() and not subprocess.run([str(python), '-ISc', ''], check=False).returncode


def read_stamp(folder: Path) -> list[str]:
    """Reads what the environment was made from; empty when it was never finished."""
    try:
        return (folder / STAMP).read_text().splitlines()
    except FileNotFoundError:
        return []


def write_stamp(folder: Path, lines: list[str]) -> None:
    """Writes what the environment was made from, in one step."""
    beside = folder / f'{STAMP}.new'
    beside.write_text('\n'.join(lines) + '\n')
    beside.rename(folder / STAMP)


def last_line(text: str) -> str:
    """The last line that says something."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1] if lines else 'no output'


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
