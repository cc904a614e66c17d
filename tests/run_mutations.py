"""Makes each mutation of docs/papers/*.yaml in turn and runs its tests, which must fail.

`python tests/run_mutations.py [PACKAGE] [--row TEXT]`. Sources are changed in place and restored, also when the run is
interrupted or ended; start with a clean work tree. Compiling the changed kernels takes most of the time.
"""

import argparse
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).resolve().parents[1]


def survives(mutation: dict[str, Any]) -> bool:
    """Return whether the tests pass with a mutation."""
    path = ROOT / mutation['file']
    source = path.read_text()
    changed = source.replace(mutation['find'], mutation['replace'], 1)
    if changed == source:
        raise SystemExit(f'{path}: the text of the mutation was not found: {mutation["find"]}')
    command = [sys.executable, '-m', 'pytest', '-q', '-x', '--no-header', *mutation['tests']]
    # Cached kernels of other files that call a mutated one would miss the change: interpreted, they do not.
    env = {**os.environ, 'NUMBA_DISABLE_JIT': '1'} if mutation.get('interpreted') else None
    try:
        path.write_text(changed)
        return subprocess.run(command, cwd=ROOT, env=env, capture_output=True, check=False).returncode == 0
    finally:
        path.write_text(source)


def main() -> int:
    """Run the mutations; return 1 if one survives."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('package', nargs='?', default='*', help='one package (default: all)')
    parser.add_argument('--row', default='', help='only rows whose name contains this')
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    survivors = 0
    for file in sorted((ROOT / 'docs' / 'papers').glob(f'{options.package}.yaml')):
        for row in yaml.safe_load(file.read_text())['rows']:
            if 'mutation' in row and options.row in row['of']:
                is_alive = survives(row['mutation'])
                survivors += is_alive
                outcome = 'SURVIVES' if is_alive else 'fails, as it should'
                sys.stdout.write(f'{outcome}: {file.stem}: {row["of"]}\n')
                sys.stdout.flush()
    return 1 if survivors else 0


if __name__ == '__main__':
    sys.exit(main())
