"""Makes one of the project's virtual environments from its lock files; standard library only.

Called by ensure.bash. The stamp is written last, and taken away before anything changes: an environment without
one was interrupted, and the next call makes it again. The lock is held by the installers, too, so that one which
outlives this process is waited for.
"""

import fcntl
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # Python's option -I leaves it out

from install_error import InstallError, explain_failure, explain_os_error
from package_sources import pip_settings, source_options, source_variables
from stamp import lock_line, read_stamp, remove_stamp, write_stamp
from uv_cache import private_cache, shares_disk

ENVIRONMENT = Path(__file__).resolve().parent
ROOT = ENVIRONMENT.parent
MARK = 'shirube.mark'
VERSION = sys.version.split()[0]
BASE_PYTHON = str(getattr(sys, '_base_executable', sys.executable))
"""The Python that an environment is made from, even when this one belongs to an environment."""
PROGRESS = ('Downloading', 'Building', 'Built', 'Prepared', 'Installed')
"""The first words of the lines of uv that say how far it is."""


def main(arguments: Sequence[str]) -> int:
    """Make or complete an environment: FOLDER PROJECT_DIGEST LOCK...; return the exit code."""
    folder, project_digest, *names = arguments
    try:
        with ExitStack() as stack:
            environment = Environment(Path(folder), stack)
            environment.complete([ENVIRONMENT / name for name in names], f'project {project_digest}')
    except InstallError as error:
        print(f'shirube: {error}', file=sys.stderr)
        return 1
    except OSError as error:
        print(f'shirube: {explain_os_error(error, ROOT)}', file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print('\nshirube: stopped; the next call starts the installation again', file=sys.stderr)
        return 130
    return 0


class Environment:
    """One virtual environment, locked for as long as the stack of locks is open.

    Attributes:
        folder: the environment.
        locks: the descriptors of the lock files, which the installers inherit.
    """

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        """Wait until no other process changes the environment.

        Raises:
            OSError: the folder around the environment cannot be written.
        """
        self.folder = folder
        self._stack = stack
        self.locks = [stack.enter_context(locked(folder.with_name(f'{folder.name}.lock')))]

    def complete(self, locks: Sequence[Path], project: str) -> None:
        """Install what is missing.

        Args:
            locks: the lock files.
            project: the stamp's line for the project itself.

        Raises:
            InstallError: an installer failed.
            OSError: a file cannot be written.
        """
        basis = [f'python {VERSION}', f'root {ROOT}']
        wanted = [lock_line(lock) for lock in locks]
        present = read_stamp(self.folder) if python_works(self.folder) else []
        if set(present) >= {*basis, *wanted, project}:
            return
        current = {lock_line(path) for path in ENVIRONMENT.glob('*.lock')}
        installed = [line for line in present if line.endswith('.lock')]
        if not installed or not set(installed) <= current or not set(basis) <= set(present):
            self.make()
            present = installed = []
        missing = [lock for lock, line in zip(locks, wanted, strict=True) if line not in installed]
        if missing:
            remove_stamp(self.folder)
            self.install_locks(missing)
        lines = [*basis, *installed, *map(lock_line, missing)]
        if project not in present:
            write_stamp(self.folder, lines)
            self.install_project()
        write_stamp(self.folder, [*lines, project])

    def make(self) -> None:
        """Make an environment with nothing but the installers, in place of one that is outdated or unfinished.

        Raises:
            InstallError: the folder is not ours, or Python or pip failed.
            OSError: a file cannot be written.
        """
        folder = self.folder
        if folder.is_symlink() or (folder.exists() and not is_ours(folder)):
            raise InstallError(f'{folder} was not made by shirube; move it away and try again')
        old, new = (folder.with_name(f'{folder.name}.{name}') for name in ('old', 'new'))
        # Renamed in one step: whenever this is interrupted, a folder of this name carries the mark.
        if folder.exists():
            remove_folder(old)
            folder.rename(old)
        for leftover in (old, new):
            remove_folder(leftover)
        new.mkdir()
        (new / MARK).touch()
        new.rename(folder)
        print(f'Making {folder} with Python {VERSION} (once, about a minute) ...', file=sys.stderr)
        self.run('python -m venv', [BASE_PYTHON, '-m', 'venv', str(folder)])
        options = ['-qq', '--no-deps', '--no-input', '--require-hashes']
        requirements = ['--requirement', str(ENVIRONMENT / 'installer.lock')]
        self.run('pip', [self.python, '-m', 'pip', 'install', *options, *requirements])

    def install_locks(self, locks: Sequence[Path]) -> None:
        """Install the packages of lock files; what is no wheel is built by the locked setuptools.

        Raises:
            InstallError: uv failed.
        """
        requirements = [word for lock in locks for word in ('--requirement', str(lock))]
        self.run_uv(['--require-hashes', *requirements])

    def install_project(self) -> None:
        """Install the project itself, from where it is.

        Raises:
            InstallError: uv failed.
        """
        # The project's metadata is written next to its sources: one environment after the other.
        self.locks.append(self._stack.enter_context(locked(ROOT / '.venv-project.lock')))
        self.run_uv(['--editable', str(ROOT)])

    def run_uv(self, arguments: Sequence[str]) -> None:
        """Let uv install packages, which is much quicker than pip.

        Raises:
            InstallError: it failed.
        """
        settings = pip_settings(self.python)
        command = [self.python, '-m', 'uv', 'pip', 'install', '--python', self.python, '--no-deps']
        command += ['--no-build-isolation', '--index-strategy', 'unsafe-best-match']
        variables = {'UV_LINK_MODE': 'copy'} if not shares_disk(self.folder) else {}
        with private_cache(self.folder) as cache:
            self.run(
                'uv',
                [*command, *source_options(settings), *arguments],
                {**source_variables(settings), **variables, **cache},
            )

    def run(self, name: str, command: Sequence[str], variables: dict[str, str] | None = None) -> None:
        """Run an installer and show how far it is.

        Args:
            name: what the message of a failure calls it.
            command: program and arguments.
            variables: environment variables in addition to those of this process.

        Raises:
            InstallError: it failed, or something ended it.
        """
        output: list[str] = []
        with subprocess.Popen(
            command,
            env={**os.environ, **(variables or {})},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding='utf-8',
            errors='replace',
            pass_fds=self.locks,
        ) as program:
            try:
                for line in program.stdout or ():
                    if line.lstrip().startswith(PROGRESS):
                        print(as_ascii(line), end='', file=sys.stderr, flush=True)
                    elif not line.startswith(' + '):
                        output.append(line.rstrip())
            except BaseException:
                program.terminate()
                raise
        if program.returncode:
            raise InstallError(explain_failure(name, program.returncode, output, self.folder))

    @property
    def python(self) -> str:
        """The environment's Python."""
        return str(self.folder / 'bin' / 'python')


@contextmanager
def locked(path: Path) -> Iterator[int]:
    """Make a second process wait that comes here at the same time; give the lock's descriptor.

    Raises:
        OSError: the lock file cannot be written.
    """
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            print('Waiting for another installation of shirube to end ...', file=sys.stderr)
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield descriptor
    finally:
        os.close(descriptor)


def is_ours(folder: Path) -> bool:
    """Return whether an environment carries the mark, or holds nothing."""
    return (folder / MARK).exists() or not any(folder.iterdir())


def remove_folder(folder: Path) -> None:
    """Remove a folder, if there is one, with all that is in it.

    Raises:
        OSError: it stays.
    """
    if folder.exists():
        shutil.rmtree(folder)


def python_works(folder: Path) -> bool:
    """Return whether the environment's Python runs; it does not once the Python it was made from is gone."""
    python = folder / 'bin/python'
    return os.access(python, os.X_OK) and not subprocess.run([str(python), '-ISc', ''], check=False).returncode


def as_ascii(text: str) -> str:
    """Return a text that any terminal can show."""
    return text.encode('ascii', 'replace').decode()


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
