"""The command ``shirube try``: calls the trial of one method."""

import sys
from collections.abc import Callable, Sequence
from importlib import import_module

from shirube_cli.project import CommandError

# Imported only when asked for, as in `shirube_cli.main`.
_TRIALS = ('floor', 'landmarks', 'lamps')
_USAGE = f'usage: shirube try {"|".join(_TRIALS)} FILE ... (--help after one of them says more)'


def try_here(arguments: Sequence[str]) -> int:
    """Run a trial; return 0 if the method suits, 1 if it does not or is not sure, 2 for what cannot be used."""
    name, *rest = arguments or ['']
    if name in {'-h', '--help'}:
        print(_USAGE)
        return 0
    try:
        if name not in _TRIALS:
            raise CommandError(_USAGE)
        trial: Callable[[Sequence[str]], int] = getattr(import_module(f'shirube_cli.suitability.{name}'), f'try_{name}')
        return trial(rest)
    except CommandError as error:
        print(f'shirube: {error}', file=sys.stderr)
        return 2
