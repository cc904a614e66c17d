"""Atomic file writes, exclusive locks between processes, and validated reading of YAML files."""

from shirube_core.files.atomic_file import atomic_write, exclusive_lock, remove_temporary_files, write_csv, write_text
from shirube_core.files.yaml_file import YamlFileError, format_value, is_number, read_yaml

__all__ = [
    'YamlFileError',
    'atomic_write',
    'exclusive_lock',
    'format_value',
    'is_number',
    'read_yaml',
    'remove_temporary_files',
    'write_csv',
    'write_text',
]
