"""The command ``shirube doctor``: one line for each finding, and what to do."""

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

from shirube_cli.doctor.findings import Finding, Severity, check_snapshot
from shirube_cli.doctor.observe import observe
from shirube_cli.project import CommandError, safe_environment
from shirube_core.files import YamlFileError, read_yaml


def doctor(arguments: Sequence[str]) -> int:
    """Look at the system and print the findings; return 1 if one is an error."""
    parser = argparse.ArgumentParser(
        prog='shirube doctor', description='Look for faults of a running system, or of this machine without one.'
    )
    add = parser.add_argument
    add('files', nargs='*', type=Path, metavar='FILE', help='parameter files to check')
    add('--seconds', type=float, default=5.0, help='how long to look (default: %(default)s)')
    add('--port', action='append', default=[], help='serial port to check')
    options = parser.parse_args(arguments)
    os.environ.update(safe_environment())
    try:
        files = {str(path): read_yaml(path) for path in options.files}
    except YamlFileError as error:
        raise CommandError(str(error)) from error
    snapshot = observe(options.seconds, files, options.port)
    findings = check_snapshot(snapshot)
    names = ', '.join(sorted(node.name for node in snapshot.nodes)) or 'none'
    print(f'nodes: {names}')
    print(report(findings))
    return int(any(finding.severity is Severity.ERROR for finding in findings))


def report(findings: Sequence[Finding]) -> str:
    """Return a line for each finding, in columns."""
    if not findings:
        return 'nothing is wrong'
    width = max(len(finding.about) for finding in findings)
    return '\n'.join(
        f'{each.severity.name.lower():<8} {each.about:<{width}}  {each.text}; {each.remedy}' for each in findings
    )
