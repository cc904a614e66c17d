"""Files that are either whole or not there, and YAML that may be wrong in every way."""

from shirube_files.whole_file import remove_halves, write_text, written_beside
from shirube_files.yaml_file import YamlFileError, is_number, read_yaml, shown

__all__ = [
    'YamlFileError',
    'is_number',
    'read_yaml',
    'remove_halves',
    'shown',
    'write_text',
    'written_beside',
]
