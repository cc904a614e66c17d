"""``shirube test``: the whole test suite."""

from collections.abc import Sequence

from shirube_cli.project import run_tool


def run_tests(arguments: Sequence[str]) -> int:
    """Run pytest at the root of the repository with the given arguments and return its exit code."""
    return run_tool('pytest', arguments)
