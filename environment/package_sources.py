"""Where packages come from: pip's settings, handed on to uv, which does not read them."""

import subprocess
import sys
from pathlib import Path
from urllib.parse import unquote, urlsplit

SOURCES = {
    'index-url': '--index-url',
    'extra-index-url': '--extra-index-url',
    'find-links': '--find-links',
    'trusted-host': '--allow-insecure-host',
}
"""pip's setting and uv's option."""


def pip_settings(python: str = sys.executable) -> dict[str, str]:
    """Return what the user's files and variables set for pip, by the setting's name.

    Args:
        python: a Python that has pip.
    """
    command = [python, '-m', 'pip', 'config', 'list']
    listed = subprocess.run(
        command, capture_output=True, text=True, encoding='utf-8', errors='replace', check=False
    ).stdout
    settings: dict[str, str] = {}
    # pip lists them by the alphabet; a variable of the environment outranks the files.
    for line in sorted(listed.splitlines(), key=lambda line: line.startswith(':env:')):
        name, _, value = line.partition('=')
        settings[name.rpartition('.')[2]] = value.strip('\'"')
    return settings


def source_options(settings: dict[str, str]) -> list[str]:
    """Return the options of uv for pip's settings, without folders that do not exist."""
    return [
        word
        for name, option in SOURCES.items()
        for source in settings.get(name, '').replace('\\n', ' ').split()
        if is_reachable(source)
        for word in (option, source)
    ]


def source_variables(settings: dict[str, str]) -> dict[str, str]:
    """Return the environment variables of uv for pip's settings."""
    variables = {}
    if 'cert' in settings:
        variables['SSL_CERT_FILE'] = settings['cert']
    if 'proxy' in settings:
        variables['ALL_PROXY'] = settings['proxy']
    return variables


def is_reachable(source: str) -> bool:
    """Return whether a source may be asked: it is on the network, or a file or folder that exists."""
    address = urlsplit(source)
    if address.scheme == 'file':
        return Path(unquote(address.path)).exists()
    return bool(address.scheme) or '/' not in source or Path(source).expanduser().exists()
