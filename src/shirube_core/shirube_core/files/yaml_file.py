"""Reading of YAML files written by users, with one-line errors."""

import math
from collections.abc import Hashable
from pathlib import Path
from typing import Any

import yaml

BYTES_MAX = 1 << 16
"""Largest size of a file written by hand [byte]."""
_SHOWN_MAX = 80
_VALUES_MAX = 1_000_000
_MERGE = 'tag:yaml.org,2002:merge'


class YamlFileError(ValueError):
    """A file cannot be read; the text is one line that names the file and what is wrong, without the remedy."""


def read_yaml(path: Path, bytes_max: int = BYTES_MAX) -> dict[str, Any]:
    """Return the fields of a YAML file.

    Args:
        path: path of the YAML file.
        bytes_max: largest allowed size [byte].

    Raises:
        YamlFileError: the file is missing, too large, not valid YAML, has no fields, or its aliases expand to more
            values than fit into memory.
    """
    try:
        with path.open('rb') as file:
            data = file.read(bytes_max + 1)
    except (OSError, ValueError) as fault:
        why = fault.strerror if isinstance(fault, OSError) else fault
        raise YamlFileError(f'{path}: cannot be read ({why})') from fault
    if len(data) > bytes_max:
        raise YamlFileError(f'{path}: holds more than {bytes_max // 1024} kB')
    try:
        content = yaml.load(data.decode('utf-8'), _Loader)  # noqa: S506 it is a SafeLoader
    except yaml.MarkedYAMLError as fault:
        line = '' if fault.problem_mark is None else f' in line {fault.problem_mark.line + 1}'
        raise YamlFileError(f'{path}: is no YAML ({fault.problem}{line})') from fault
    except (ValueError, OverflowError, RecursionError, yaml.YAMLError) as fault:
        raise YamlFileError(f'{path}: is no YAML') from fault
    if not isinstance(content, dict):
        raise YamlFileError(f'{path}: holds no fields')
    return content


def format_value(value: object) -> str:
    """Format a value for an error message: one line of limited length."""
    text = ' '.join(repr(value).split())
    return text if len(text) <= _SHOWN_MAX else f'{text[: _SHOWN_MAX - 3]}...'


def is_number(value: object) -> bool:
    """Return whether a value of a YAML file is a finite number that a float can hold."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:
        return False


class _Loader(yaml.SafeLoader):
    """A SafeLoader that rejects alias bombs and duplicate keys."""

    def get_single_node(self) -> yaml.Node | None:
        """Return the document, unless its aliases expand to too many values."""
        node = super().get_single_node()
        if node is not None and _count(node, {}) > _VALUES_MAX:
            raise yaml.MarkedYAMLError(problem='its aliases expand to too many values')
        return node

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        """Return the fields of a mapping; duplicate keys are rejected, since the first value would be lost."""
        known = set()
        for key, _ in node.value:
            name = (key.tag, key.value) if isinstance(key, yaml.ScalarNode) else None
            if name in known and key.tag != _MERGE:
                problem = f'{key.value} appears twice'
                raise yaml.MarkedYAMLError(problem=problem, problem_mark=key.start_mark)
            known |= {name} - {None}
        return super().construct_mapping(node, deep)


def _count(node: yaml.Node, known: dict[int, int]) -> int:
    """Return the number of values that a node expands to; ``known`` caches the counts by node."""
    if id(node) not in known:
        known[id(node)] = _VALUES_MAX + 1  # for a node that contains itself
        if isinstance(node, yaml.MappingNode):
            parts = [part for pair in node.value for part in pair]
        else:
            parts = node.value if isinstance(node, yaml.SequenceNode) else []
        known[id(node)] = 1 + sum(_count(part, known) for part in parts)
    return known[id(node)]
