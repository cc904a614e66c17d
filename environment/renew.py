"""Renews the lock files from the dependencies in pyproject.toml.

Run it with Python 3.11 to renew runtime.lock and dev.lock (what 3.11 takes 3.12 takes too), and with
Python 3.12 to renew oldest.lock.
"""

import json
import subprocess
import sys
import tomllib
from pathlib import Path

ENVIRONMENT = Path(__file__).resolve().parent
HEADS = {
    'runtime': 'What the nodes and commands need, every package pinned; valid on Python 3.11 and 3.12.\n'
    '# CONTRIBUTING.md says how to renew it.',
    'dev': 'What tests, checks and benchmarks need on top of runtime.lock.',
    'oldest': 'The oldest supported set: Python 3.12 with numpy, scipy and OpenCV as on Ubuntu 24.04; for .ci/run.',
}


def main() -> None:
    """Resolves the dependencies afresh and writes the lock files that this Python is the right one for."""
    project = tomllib.loads((ENVIRONMENT.parent / 'pyproject.toml').read_text())['project']
    extras = project['optional-dependencies']
    runtime, oldest = project['dependencies'], extras['oldest']
    if sys.version_info < (3, 12):
        needed = resolve(runtime)
        pinned = [f'{name}=={version}' for name, version in needed.items()]
        everything = resolve([*pinned, *extras['test'], *extras['check'], *extras['bench']])
        write_lock('runtime', needed)
        write_lock('dev', {name: version for name, version in everything.items() if name not in needed})
    else:
        write_lock('oldest', resolve([*oldest, *runtime, *extras['test']]))


def resolve(requirements: list[str]) -> dict[str, str]:
    """Returns name and version of everything that the requirements need."""
    command = [
        sys.executable,
        '-m',
        'pip',
        'install',
        '--dry-run',
        '--ignore-installed',
        '--quiet',
        '--report',
        '-',
    ]
    report = json.loads(subprocess.run([*command, *requirements], capture_output=True, check=True).stdout)
    return {item['metadata']['name']: item['metadata']['version'] for item in report['install']}


def write_lock(name: str, pins: dict[str, str]) -> None:
    """Writes one lock file, in the order of the alphabet."""
    lines = sorted((f'{package}=={version}' for package, version in pins.items()), key=str.lower)
    (ENVIRONMENT / f'{name}.lock').write_text('\n'.join([f'# {HEADS[name]}', *lines, '']))


if __name__ == '__main__':
    main()
