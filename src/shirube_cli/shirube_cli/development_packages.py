"""The packages that only tests, checks and benchmarks need; they are installed when one of these is first used."""

import subprocess
import sys
from pathlib import Path

from shirube_cli.error import CommandError
from shirube_cli.project import find_root

_SCRIPT = 'source "$0/environment/ensure.bash"; forget_other_environments; ensure_development "$0"'


def install_development_packages() -> None:
    """Complete the environment that ``./shirube`` made; leave every other one as it is.

    Raises:
        CommandError: they cannot be installed; the reason was printed.
    """
    root = find_root()
    if Path(sys.prefix) != root / '.venv':
        return
    if subprocess.run(['bash', '-c', _SCRIPT, str(root)], check=False).returncode:
        raise CommandError('the packages for tests, checks and benchmarks are not installed; see above')
