"""Files that are either whole or not there."""

from shirube_files.whole_file import write_text, written_beside

__all__ = ['write_text', 'written_beside']
