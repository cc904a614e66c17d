"""Atomic file writes, exclusive locks between processes, and validated reading of YAML files."""

import csv
import fcntl
import io
import math
import os
import stat
import tempfile
from collections.abc import Hashable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import yaml


@contextmanager
def exclusive_lock(folder: Path, *, file: str = '', wait: bool = True) -> Iterator[None]:
    """Hold an exclusive lock on a folder, which is created if it does not exist; other processes wait for it.

    Args:
        folder: the folder.
        file: name of a file in it to lock instead; network file systems lock only files opened for writing.
        wait: whether to wait for another process.

    Raises:
        BlockingIOError: another process holds the lock, without ``wait``.
        OSError: the folder cannot be created.
    """
    folder.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(folder / file, os.O_CREAT | os.O_WRONLY if file else os.O_RDONLY, 0o666)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(descriptor)


_ANY_SUFFIX = 8 * '?'
"""Pattern of the random suffix of `tempfile`."""


@contextmanager
def atomic_write(path: Path) -> Iterator[BinaryIO]:
    """Open a temporary file for writing; rename it to ``path`` at the end, or remove it on an error.

    The folder is created if needed. The permissions of an existing file are kept.

    Raises:
        OSError: the file cannot be written; the error names ``path``.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        handle, name = tempfile.mkstemp(prefix=f'.{path.name}.', dir=path.parent)
    except OSError as fault:
        raise OSError(fault.errno, fault.strerror, str(path)) from fault
    temporary = Path(name)
    try:
        with os.fdopen(handle, 'wb') as file:
            yield file
        temporary.chmod(_mode_of(path))
        _rename(temporary, path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def remove_temporary_files(folder: Path, names: str) -> None:
    """Remove temporary files of killed processes; no process may be writing in the folder."""
    for leftover in folder.glob(f'.{names}.{_ANY_SUFFIX}'):
        leftover.unlink(missing_ok=True)


def _rename(temporary: Path, path: Path) -> None:
    try:
        temporary.replace(path)
    except OSError as fault:
        raise OSError(fault.errno, fault.strerror, str(path)) from fault


def _mode_of(path: Path) -> int:
    """Return the permissions of a file, or the default ones for a new file (mkstemp makes private files)."""
    try:
        return stat.S_IMODE(path.stat().st_mode)
    except FileNotFoundError:
        umask = os.umask(0)
        os.umask(umask)
        return 0o666 & ~umask


def write_text(path: Path | str, text: str) -> None:
    """Write a UTF-8 text file atomically."""
    with atomic_write(Path(path)) as file:
        file.write(text.encode())


def write_csv(path: Path | str, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a CSV file with a header atomically."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator='\n')
    table.writerow(columns)
    table.writerows(rows)
    write_text(path, text.getvalue())


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
