"""Atomic file writes, exclusive locks between processes, and validated reading of YAML files."""

from shirube_files.folder_lock import locked
from shirube_files.whole_file import remove_halves, write_text, written_beside
from shirube_files.yaml_file import YamlFileError, is_number, read_yaml, shown

__all__ = [
    'YamlFileError',
    'is_number',
    'locked',
    'read_yaml',
    'remove_halves',
    'shown',
    'write_text',
    'written_beside',
]
