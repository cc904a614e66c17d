"""The command ``shirube``: reads what is asked and hands it to the file that does it."""

import sys
from collections.abc import Callable, Sequence
from importlib import import_module

from shirube_cli.error import CommandError

USAGE = """\
usage: shirube <command> [arguments …]

  demo [mission]                 all nodes drive a simulated robot to three goals; report in out/demo/
  demo floor                     replay the recorded drive through the live node; report in out/demo/
  run <package> <executable> …   start an executable, as `ros2 run` does
  test [pytest arguments]        run the tests
  check [--fix]                  format, lint and types
  bench <name>                   run one of the benchmarks
"""
# Imported only when asked for: `run` should start quickly.
COMMANDS = {
    'demo': ('shirube_cli.demo', 'demo'),
    'run': ('shirube_cli.run', 'run'),
    'test': ('shirube_cli.run_tests', 'run_tests'),
    'check': ('shirube_cli.check', 'check'),
    'bench': ('shirube_cli.bench', 'bench'),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command that the arguments name and return its exit code."""
    name, *rest = (sys.argv[1:] if arguments is None else arguments) or ['--help']
    if name in {'-h', '--help', 'help'}:
        print(USAGE, end='')
        return 0
    if name not in COMMANDS:
        print(f'shirube: there is no command {name!r}\n{USAGE}', end='', file=sys.stderr)
        return 1
    module, function = COMMANDS[name]
    command: Callable[[Sequence[str]], int] = getattr(import_module(module), function)
    try:
        return command(rest)
    except CommandError as error:
        print(f'shirube: {error}', file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130


def bags_main() -> int:
    """The command ``shirube_bags play …``: short for ``shirube run shirube_bags play …``."""
    return main(['run', 'shirube_bags', *sys.argv[1:]])
