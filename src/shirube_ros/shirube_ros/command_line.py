"""The command line of a node: help, and errors that rcl would pass over in silence or report in its own words."""

import inspect
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import yaml

from shirube_core.settings import SettingDescription, SettingsError, describe_settings

_PARAMETERS = 'ros__parameters'
_HELP_OPTIONS = ('-h', '--help')
_INTEGER, _NUMBER = r'[-+]?\d+', r'[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?'


class CommandLineError(SettingsError):
    """An argument or a parameter file that the node would ignore; one line with the remedy."""


@dataclass
class Arguments:
    """The arguments of a node.

    Attributes:
        others: arguments outside of ``--ros-args``.
        files: parameter files.
        parameters: values given by ``-p``, by name.
        name: name of the node, as remapped.
        namespace: its namespace, as remapped.
    """

    name: str
    namespace: str = '/'
    others: list[str] = field(default_factory=list)
    files: list[str] = field(default_factory=list)
    parameters: dict[str, str] = field(default_factory=dict)

    @property
    def full_name(self) -> str:
        """The name of the node with its namespace."""
        return f'{self.namespace.rstrip("/")}/{self.name}'


def parse_arguments(name: str, arguments: Sequence[str]) -> Arguments:
    """Sort the arguments of a node with a default name."""
    parsed, is_ros, expected = Arguments(name), False, ''
    for argument in arguments:
        if expected:
            _add_option(parsed, expected, argument)
            expected = ''
        elif argument in ('--ros-args', '--'):
            is_ros = argument == '--ros-args'
        elif not is_ros:
            parsed.others.append(argument)
        elif argument in ('-p', '--param', '-r', '--remap', '--params-file'):
            expected = argument
    return parsed


def _add_option(parsed: Arguments, option: str, value: str) -> None:
    left, _, right = value.partition(':=')
    if option == '--params-file':
        parsed.files.append(value)
    elif option in ('-p', '--param'):
        parsed.parameters[left.rpartition(':')[2]] = right
    elif left.endswith(('__node', '__name')):
        parsed.name = right
    elif left.endswith('__ns'):
        parsed.namespace = right


def check_arguments(name: str, arguments: Sequence[str]) -> list[str]:
    """Check the command line of a node; return one-line warnings.

    Raises:
        CommandLineError: a stray argument, a parameter file for other nodes only, or a list of mixed types.
    """
    parsed = parse_arguments(name, arguments)
    if parsed.others:
        raise CommandLineError(_stray_message(parsed.others))
    for parameter, text in parsed.parameters.items():
        _check_lists(yaml.compose(text, Loader=yaml.SafeLoader), f'-p {parameter}', '')
    warnings = []
    for file in parsed.files:
        try:
            root = yaml.compose(Path(file).read_text(), Loader=yaml.SafeLoader)
        except (OSError, UnicodeError, yaml.YAMLError):
            continue  # rcl names file and line
        warnings += _check_file(file, parsed, root)
    return warnings


def _stray_message(others: Sequence[str]) -> str:
    for option, value in pairwise([*others, '']):
        if option in ('-p', '--param', '-r', '--remap', '--params-file'):
            return f'{option} {value} has no effect here; write --ros-args {option} {value} (--help shows how)'
    return (
        f'argument {others[0]!r} has no effect; a node takes parameters, such as --ros-args -p name:={others[0]} '
        '(--help lists them)'
    )


def _check_file(file: str, parsed: Arguments, root: Any) -> list[str]:
    sections = list(_sections(root, ''))
    for _, parameters in sections:
        _check_lists(parameters, file, '')
    names = [name for name, _ in sections]
    matching = [name for name in names if _matches(name, parsed.full_name)]
    others = [name for name in names if name.rpartition('/')[2] == parsed.name and name not in matching]
    remedy = f'this node is {parsed.full_name}; rename the section, or write /**: for any node'
    if sections and not matching:
        raise CommandLineError(f'{file}: has parameters of {", ".join(names)} only; {remedy}')
    return [f'{file}: the parameters of {name} are not used: {remedy}' for name in others]


def _sections(node: Any, prefix: str) -> Iterator[tuple[str, Any]]:
    """Return name and parameters of each section; names are nested or joined by slashes."""
    for key, value in node.value if isinstance(node, yaml.MappingNode) else ():
        if key.value == _PARAMETERS:
            yield prefix or '/', value
        else:
            yield from _sections(value, f'{prefix}/{key.value.strip("/")}')


def _matches(pattern: str, full_name: str) -> bool:
    """Return whether a name with wildcards is that of a node: * is one part, ** any number of parts."""
    parts = {'**': '(/[^/]+)*', '*': '/[^/]+'}
    tokens = [parts.get(part, '/' + re.escape(part)) for part in pattern.split('/')[1:]]
    return re.fullmatch(''.join(tokens), full_name) is not None


def _check_lists(node: Any, source: str, name: str) -> None:
    """Reject lists of whole and decimal numbers, which rcl refuses in words of its own."""
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            _check_lists(value, source, f'{name}.{key.value}' if name else key.value)
    if not isinstance(node, yaml.SequenceNode):
        return
    texts = [each.value for each in node.value if isinstance(each, yaml.ScalarNode) and each.style is None]
    whole = [re.fullmatch(_INTEGER, text) is not None for text in texts]
    if all(re.fullmatch(_NUMBER, text) for text in texts) and any(whole) and not all(whole):
        numbers = [f'{text}.0' if is_whole else text for text, is_whole in zip(texts, whole, strict=True)]
        what = f'{source}: {name} is' if name else f'{source} is'
        raise CommandLineError(
            f'{what} [{", ".join(texts)}], which mixes whole and decimal numbers; write [{", ".join(numbers)}]'
        )


def wants_help(name: str, arguments: Sequence[str]) -> bool:
    """Return whether the arguments ask for help."""
    return any(argument in _HELP_OPTIONS for argument in parse_arguments(name, arguments).others)


def help_text(name: str, node: object) -> str:
    """Return what a node does, its topics and its parameters, from its docstring and its settings classes."""
    classes = (*getattr(node, 'COMMON_SETTINGS', ()), *getattr(node, 'SETTINGS', ()))
    rows = [_parameter_line(each) for cls in classes for each in describe_settings(cls)]
    about = '\n'.join(_plain(line) for line in (inspect.getdoc(node) or '').splitlines())
    parts = [
        f'usage: ros2 run <package> node --ros-args -p <parameter>:=<value> … --params-file <file.yaml> …\n\n{about}',
        'parameters (default; allowed; * can change at run time, by ros2 param set):',
        *rows,
        f'\na parameter file:\n/**:  # any node; or /{name}\n  {_PARAMETERS}:\n    <parameter>: <value>',
    ]
    return '\n'.join(parts)


def _plain(line: str) -> str:
    """Return a line of a docstring without its markup; the columns of a table stay aligned."""
    return re.sub(r'``(.*?)``', r'\1', re.sub(r'^``(.*?)``', r'\1    ', line))


def _parameter_line(each: SettingDescription) -> str:
    default = list(each.default) if isinstance(each.default, tuple) else each.default
    limits = '' if each.limits == 'any' else f'; {each.limits}'
    mark = '*' if each.is_tunable else ' '
    return f' {mark}{each.name} ({default!r}{limits}): {each.description}'
