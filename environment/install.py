"""Makes one of the project's virtual environments from its lock files; standard library only.

Called by ensure.bash. The stamp is written last, so that an installation that was cut off is seen as such
and done again.
"""

import fcntl
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ENVIRONMENT = Path(__file__).resolve().parent
ROOT = ENVIRONMENT.parent
MARK = 'shirube.mark'
STAMP = 'shirube.stamp'
VERSION = sys.version.split()[0]


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
        run_pip(folder, ['--no-build-isolation', '--editable', str(ROOT)], 'Installing shirube itself', 1)
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
    print(f'Making {folder} with Python {VERSION} (once, one to three minutes) …', file=sys.stderr)
    made = subprocess.run(
        [sys.executable, '-m', 'venv', str(folder)], capture_output=True, text=True, check=False
    )
    if made.returncode:
        raise InstallError(f'python -m venv {folder} failed: {last_line(made.stdout + made.stderr)}')
    pins = sum(line[:1].isalnum() for lock in locks for line in lock.read_text().splitlines())
    requirements = [word for lock in locks for word in ('--requirement', str(lock))]
    run_pip(folder, requirements, 'Installing pinned packages', pins)


def run_pip(folder: Path, arguments: list[str], title: str, count: int) -> None:
    """Runs pip in the environment and shows how far it is; its own words go to a log."""
    log = folder / 'shirube-install.log'
    command = [
        str(folder / 'bin/python'),
        '-m',
        'pip',
        'install',
        '--no-deps',
        '--no-compile',  # Python compiles what is imported, which is a part of it
        '--no-input',
        '--progress-bar',
        'off',
    ]
    command += ['--disable-pip-version-check', *arguments]
    before = count_installed(folder)
    with log.open('w') as output:
        pip = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
        progress = Progress(title, 2 * count)
        try:
            while pip.poll() is None:
                time.sleep(0.2)
                fetched = log.read_text(errors='replace').count('Collecting ')
                progress.show(fetched + count_installed(folder) - before)
        except BaseException:
            pip.terminate()
            raise
    progress.end()
    if pip.returncode:
        reason = last_line(log.read_text(errors='replace'))
        raise InstallError(f'pip failed, see {log} (is the network there?): {reason}')


def python_works(folder: Path) -> bool:
    """Tells whether the environment's Python runs; it does not once the Python it was made from is gone."""
    python = folder / 'bin/python'
    return python.exists() and not subprocess.run([str(python), '-ISc', ''], check=False).returncode


def count_installed(folder: Path) -> int:
    """Counts the packages that pip has finished in the environment."""
    return sum(1 for _ in folder.glob('lib/python3*/site-packages/*.dist-info/INSTALLER'))


class Progress:
    """A progress bar on a terminal; elsewhere a line for every fifth of the way."""

    def __init__(self, title: str, total: int) -> None:
        """Starts at nothing done of `total` steps."""
        self.title, self.total, self.start = title, total, time.monotonic()
        self.terminal = sys.stderr.isatty()
        self.shown = -1

    def show(self, done: int) -> None:
        """Shows how many steps are done."""
        percent = min(99, 100 * done // self.total)
        seconds = time.monotonic() - self.start
        if self.terminal:
            bar = ('#' * (percent // 4)).ljust(25, '.')
            print(
                f'\r{self.title} [{bar}] {percent:3d} % {seconds:4.0f} s', end='', file=sys.stderr, flush=True
            )
        elif percent // 20 > self.shown:
            self.shown = percent // 20
            print(f'{self.title}: {percent} % after {seconds:.0f} s', file=sys.stderr, flush=True)

    def end(self) -> None:
        """Closes the line."""
        seconds = time.monotonic() - self.start
        start, fill = ('\r', ' ' * 40) if self.terminal else ('', '')
        print(f'{start}{self.title}: {seconds:.0f} s{fill}', file=sys.stderr, flush=True)


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
