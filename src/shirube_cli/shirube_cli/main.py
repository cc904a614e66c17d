"""The command ``shirube``: reads the arguments and calls the module of the subcommand."""

import errno
import io
import os
import sys
from collections.abc import Callable, Sequence
from importlib import import_module

from shirube_cli.project import CommandError

USAGE = """\
usage: shirube <command> [arguments ...]

  demo [mission]                  all nodes drive a simulated robot to three goals; report in out/demo/
  demo mission --planner paper    the same with the paper's map and reward rule
  demo floor                      replay the recorded drive through the live node; report in out/demo/
  view [BAG ...]                  the live page in the browser: watch, set goals, drive by hand, stop, replay
  run <package> <executable> ...  start an executable, as `ros2 run` does
  list                            the packages with their executables, and the benchmarks
  test [--quick] [pytest args]    run the tests; --quick: only those that guard every commit
  check [--fix]                   format, lint and types
  bench <name>                    run one of the benchmarks
  migrate FILE ...                rename former parameters in your parameter files
  try floor|landmarks|lamps FILE  will it work here? from photographs or a film of yours
  doctor [FILE ...]               what is wrong with the running nodes, the machine or parameter files
  --version                       the version, and where it is installed
"""
FULL_DISK = {errno.ENOSPC, errno.EDQUOT}
REFUSALS = {*FULL_DISK, errno.EACCES, errno.EPERM, errno.EROFS, errno.EPIPE}
"""Errors of the operating system that are no fault of the program."""
# Imported only when asked for: `run` should start quickly.
COMMANDS = {
    'demo': ('shirube_cli.demo', 'demo'),
    'run': ('shirube_cli.run', 'run'),
    'view': ('shirube_cli.run', 'view'),
    '--version': ('shirube_cli.run', 'print_version'),
    'list': ('shirube_cli.run', 'list_programs'),
    'test': ('shirube_cli.develop', 'run_tests'),
    'check': ('shirube_cli.develop', 'check'),
    'bench': ('shirube_cli.develop', 'bench'),
    'migrate': ('shirube_cli.migrate', 'migrate'),
    'try': ('shirube_cli.suitability.command', 'try_here'),
    'doctor': ('shirube_cli.doctor.command', 'doctor'),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command that the arguments name and return its exit code."""
    _replace_unprintable()
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
        code = command(rest)
        sys.stdout.flush()
    except CommandError as error:
        print(f'shirube: {error}', file=sys.stderr)
        return 1
    except OSError as error:
        if error.errno not in REFUSALS:
            raise
        print(f'shirube: {_explain(error)}', file=sys.stderr)
        _drop_output()
        return 1
    except KeyboardInterrupt:
        return 130
    return code


def bags_main() -> int:
    """The command ``shirube_bags play ...``: short for ``shirube run shirube_bags play ...``."""
    return main(['run', 'shirube_bags', *sys.argv[1:]])


def _replace_unprintable() -> None:
    """Print a question mark for what the terminal's encoding lacks, instead of failing."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors='replace')


def _drop_output() -> None:
    """Let Python's own last flush of what cannot be written succeed."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _explain(error: OSError) -> str:
    if error.errno == errno.EPIPE:
        return 'nobody reads the output any more'
    path = error.filename or 'the output'
    if error.errno in FULL_DISK:
        return f'the disk is full: cannot write {path}; free some space and try again'
    return f'no permission to write {path}; work in a folder of your own (a clone: copy it there)'
