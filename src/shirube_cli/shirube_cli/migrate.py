"""``shirube migrate``: gives parameters in YAML files their present names, for a node in any namespace."""

import argparse
import difflib
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from shirube_cli.project import CommandError
from shirube_cli.settings_of_nodes import SETTINGS_OF_NODES
from shirube_core.files import YamlFileError, read_yaml, write_text
from shirube_core.settings import describe_settings

PARAMETERS = 'ros__parameters'
_KEY = re.compile(r'^(?P<indent> *)(?P<quote>[\'"]?)(?P<key>[^\s:#\'"{}\[\],&*!|>%@-][^\s:#\'"]*)(?P=quote) *:(?= |$)')


def migrate(arguments: Sequence[str]) -> int:
    """Rewrite files in place and print what changed; raise a CommandError if a file cannot be read or rewritten."""
    parser = argparse.ArgumentParser(
        prog='shirube migrate',
        description='Rename former parameters in ROS parameter files, and make their sections those of '
        'nodes in any namespace; taught places need no change.',
    )
    parser.add_argument('files', nargs='+', type=Path, metavar='FILE', help='parameter file or taught place (YAML)')
    parser.add_argument('--dry-run', action='store_true', help='only print the changes')
    options = parser.parse_args(arguments)
    for path in options.files:
        migrate_file(path, dry_run=options.dry_run)
    return 0


def migrate_file(path: Path, *, dry_run: bool = False) -> None:
    """Rename the former parameters of a YAML file, except in a dry run; comments and layout stay.

    Raises:
        CommandError: the file is not valid YAML or has a former name where only a person can change it.
    """
    try:
        read_yaml(path)
        text = path.read_text()
        changed = widen_root(rename_parameters(text))
        remaining = sorted(former_names_in(yaml.safe_load(changed)))
        if remaining:
            raise CommandError(f'{path}: rename {", ".join(remaining)} by hand; write one "name: value" a line')
        if changed == text:
            print(f'{path}: nothing to change')
            return
        print(
            *difflib.unified_diff(text.splitlines(), changed.splitlines(), str(path), 'now', lineterm='', n=0), sep='\n'
        )
        if not dry_run:
            write_text(path, changed)
    except YamlFileError as error:
        raise CommandError(str(error)) from error


def former_names(node: str) -> dict[str, str]:
    """Return former and present parameter names of a node; those of all nodes for a name with a wildcard."""
    classes = [
        cls
        for name, sections in SETTINGS_OF_NODES.items()
        if '*' in node or node.rpartition('/')[2] == name
        for cls in sections.values()
    ]
    descriptions = [description for cls in classes for description in describe_settings(cls)]
    return {one.former_name: one.name for one in descriptions if one.former_name}


def rename_parameters(text: str) -> str:
    """Return the text of a parameter file, valid YAML, with present names."""
    lines = text.splitlines(keepends=True)
    above: list[tuple[int, str]] = []  # indentation and key of the mappings around a line
    for number, line in enumerate(lines):
        match = _KEY.match(line)
        if match is None:
            continue
        indent = len(match['indent'])
        above = [(depth, key) for depth, key in above if depth < indent]
        keys = [*(key for _, key in above), match['key']]
        above.append((indent, match['key']))
        if PARAMETERS not in keys[:-1]:
            continue
        split = keys.index(PARAMETERS)
        names = former_names('/'.join(keys[:split]))
        former = '.'.join(keys[split + 1 :])
        if former in names:
            group = '.'.join(keys[split + 1 : -1])
            present = names[former].removeprefix(f'{group}.') if group else names[former]
            lines[number] = line[: match.start('key')] + present + line[match.end('key') :]
    return ''.join(lines)


def widen_root(text: str) -> str:
    """Return the text of a parameter file whose sections of nodes are for any namespace.

    A node in a namespace does not read a section of its bare name. In a file for one node ``/**`` replaces the name.
    """
    content = yaml.safe_load(text)
    names = [str(name) for name in content] if isinstance(content, Mapping) else []
    for name in names:
        node = name.strip('/')
        if node in SETTINGS_OF_NODES:
            root = f'/**/{node}' if len(names) > 1 else '/**'
            text = re.sub(rf'(?m)^([\'"]?){re.escape(name)}\1 *:', f'{root}:', text, count=1)
    return text


def former_names_in(content: object, path: tuple[str, ...] = ()) -> Iterator[str]:
    """Yield the former parameter names in the content of a parameter file."""
    if not isinstance(content, Mapping):
        return
    for key, value in content.items():
        if key == PARAMETERS:
            names = former_names('/'.join(path))
            yield from (name for name in _parameter_names(value, '') if name in names)
        else:
            yield from former_names_in(value, (*path, str(key)))


def _parameter_names(content: Any, prefix: str) -> Iterator[str]:
    if isinstance(content, Mapping):
        for key, value in content.items():
            yield f'{prefix}{key}'
            yield from _parameter_names(value, f'{prefix}{key}.')
