"""Builds the wheel, installs it in an environment of its own and uses it there, away from the clone."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / 'environment'))

from package_sources import pip_settings, source_options, source_variables  # noqa: E402
from uv_cache import shares_disk  # noqa: E402

LIBRARY = """
import shirube
route = shirube.plan([[0, 0, 0], [100, 100, 0], [0, 0, 0]], start=(0, 0), goal=(2, 0))
print(route.length, route.reason)
raise SystemExit(route.reason is not None)
"""


def main() -> int:
    """Return 0 when every command answered; raise CalledProcessError for the first that did not."""
    with tempfile.TemporaryDirectory(dir=sys.argv[1]) as folder:
        try_wheel(Path(folder))
    return 0


def try_wheel(folder: Path) -> None:
    """Build, install and try the wheel in a folder."""
    settings = pip_settings()
    variables = {name: value for name, value in os.environ.items() if name != 'VIRTUAL_ENV'}
    variables |= source_variables(settings) | ({} if shares_disk(folder) else {'UV_LINK_MODE': 'copy'})

    def run(*command: object) -> None:
        print('+', *command, flush=True)
        subprocess.run([*map(str, command)], cwd=folder, env=variables, check=True)

    uv, python = Path(sys.prefix, 'bin', 'uv'), folder / 'new' / 'bin' / 'python'
    # A copy: setuptools leaves a folder build where it builds, which is checked and tested meanwhile.
    source = folder / 'source'
    run('git', 'clone', '--quiet', ROOT, source)
    run(
        uv,
        'build',
        '--quiet',
        '--wheel',
        '--no-build-isolation',
        '--python',
        sys.executable,
        '--out-dir',
        folder,
        source,
    )
    run(uv, 'venv', '--quiet', '--python', sys.executable, 'new')
    versions = ['--constraints', ROOT / 'environment' / 'runtime.lock', '--index-strategy', 'unsafe-best-match']
    wheel = next(folder.glob('*.whl'))
    run(uv, 'pip', 'install', '--quiet', '--python', python, *versions, *source_options(settings), wheel)
    shirube = folder / 'new' / 'bin' / 'shirube'
    run(shirube, '--version')
    run(shirube, 'list')
    run(python, ROOT / '.ci' / 'start_node.py', shirube, 'run', 'pose_arbiter', 'node')
    run(python, '-c', LIBRARY)


if __name__ == '__main__':
    sys.exit(main())
