"""Renews the lock files from the dependencies in pyproject.toml: ``.venv/bin/python environment/renew.py``.

With ``--keep`` only what pyproject.toml asks for changes; all other packages keep their version. Asked is the index of
pip's settings alone: a second one may hold some of a version's files only, and so some of its hashes. No address
is written into a lock file.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Sequence
from pathlib import Path

from package_sources import pip_settings, source_options, source_variables

ENVIRONMENT = Path(__file__).resolve().parent
SECOND_SOURCES = ('extra-index-url', 'find-links')
UV = Path(sys.prefix, 'bin', 'uv')
PLATFORM = " and platform_machine == 'x86_64' and sys_platform == 'linux'"
EVERYWHERE = f" ; python_full_version < '3.13'{PLATFORM}"
"""The conditions that uv adds to each package: those of pyproject.toml's `tool.uv`."""
HEADS = {
    'runtime': 'The packages of nodes and commands, for Python 3.11 and 3.12.',
    'dev': 'The packages that tests, checks and benchmarks need in addition to runtime.lock.',
    'oldest': 'The oldest supported set: Python 3.12 with numpy, scipy and OpenCV as on Ubuntu 24.04; for .ci/run.',
    'installer': 'What installs all other packages, and what builds those that are not published as wheels.',
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Resolve the dependencies and write all lock files; return 0."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--keep', action='store_true', help='keep the version of each locked package')
    options = [] if parser.parse_args(arguments).keep else ['--upgrade']
    project = tomllib.loads((ENVIRONMENT.parent / 'pyproject.toml').read_text())['project']
    extras = project['optional-dependencies']
    runtime = [*project['dependencies'], *extras['workspace']]
    development = [*runtime, *extras['cluster'], *extras['test'], *extras['check'], *extras['bench']]
    needed = compile_lock(runtime, 'runtime', '3.11', options)
    write_lock('runtime', needed)
    locked = ['--constraints', str(ENVIRONMENT / 'runtime.lock')]
    everything = compile_lock(development, 'dev', '3.11', [*options, *locked])
    write_lock('dev', {name: entry for name, entry in everything.items() if name not in needed})
    write_lock('installer', compile_lock(['setuptools', 'uv'], 'installer', '3.11', [*options, *locked]))
    oldest = [*extras['oldest'], *runtime, *extras['cluster'], *extras['test']]
    write_lock('oldest', compile_lock(oldest, 'oldest', '3.12', options))
    return 0


def compile_lock(requirements: list[str], name: str, python: str, options: list[str]) -> dict[str, str]:
    """Resolve requirements, preferring the locked versions unless the options say otherwise.

    Args:
        requirements: the direct dependencies, as in pyproject.toml.
        name: the lock file's name without its ending.
        python: the oldest version of Python that the packages must run on.
        options: more options of ``uv pip compile``.

    Returns:
        the lock file's entry of each package, with the hashes of all its files, by the package's name.
    """
    settings = {name: value for name, value in pip_settings().items() if name not in SECOND_SOURCES}
    with tempfile.TemporaryDirectory() as folder:
        wanted, output = Path(folder, 'wanted.in'), Path(folder, 'output.lock')
        wanted.write_text('\n'.join(requirements))
        known = ENVIRONMENT / f'{name}.lock'
        output.write_text(known.read_text() if known.exists() else '')
        command = [str(UV), 'pip', 'compile', '--quiet', '--universal', '--fork-strategy', 'fewest']
        command += ['--generate-hashes', '--no-header', '--no-annotate', '--python-version', python]
        command += [*source_options(settings), *options]
        command += ['--output-file', str(output), str(wanted)]
        variables = {**os.environ, **source_variables(settings)}
        subprocess.run(command, cwd=ENVIRONMENT.parent, env=variables, check=True, stdout=subprocess.DEVNULL)
        text = output.read_text().replace(EVERYWHERE, '').replace(PLATFORM, '')
    return split_entries(text)


def split_entries(text: str) -> dict[str, str]:
    """Return the entry of each package in the text of a lock file, by the package's name."""
    entries: dict[str, str] = {}
    name = ''
    for line in text.splitlines(keepends=True):
        if not line.startswith((' ', '#', '-', '\n')):
            name = line.partition('==')[0]
        if name and not line.startswith('#'):
            entries[name] = entries.get(name, '') + line
    return entries


def write_lock(name: str, entries: dict[str, str]) -> None:
    """Write one lock file."""
    head = f'# {HEADS[name]}\n# Made by environment/renew.py; CONTRIBUTING.md says how.\n'
    (ENVIRONMENT / f'{name}.lock').write_text(head + ''.join(entries.values()))


if __name__ == '__main__':
    sys.exit(main())
