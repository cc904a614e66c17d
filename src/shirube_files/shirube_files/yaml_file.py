"""Reading of YAML files that people write, and that may be wrong in every way."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import yaml

BYTES_MAX = 1 << 16
"""Of a file that people write by hand."""
_SHOWN_MAX = 80


class YamlFileError(ValueError):
    """A file cannot be read; the text is one line that names the file and what is wrong, without the remedy."""


def read_yaml(path: Path, bytes_max: int = BYTES_MAX) -> dict[str, Any]:
    """Return the fields of a YAML file.

    Args:
        path: of the file.
        bytes_max: larger files are refused.

    Raises:
        YamlFileError: the file is missing, too large or no YAML, or holds no fields or an alias: a few lines of aliases
            can stand for more values than fit into memory.
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


def shown(value: object) -> str:
    """Return a value as it is shown in a message: one line that is not long."""
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
    """A SafeLoader without aliases."""

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        """Compose the next node, unless it is an alias."""
        if self.check_event(yaml.AliasEvent):
            mark = self.peek_event().start_mark  # type: ignore[no-untyped-call]
            raise yaml.MarkedYAMLError(problem='an alias, which is not allowed', problem_mark=mark)
        return super().compose_node(parent, index)
