"""Read a CSV dot map in chunks: byte ranges that end at a line break."""

import hashlib
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from floor_localizer.core.arrays import Floats
from floor_localizer.core.errors import DotMapError
from floor_localizer.files.dot_map_file import check_dots, check_header, parse_rows

# Longer than any line of a dot map.
_MAX_LINE_BYTES = 1 << 12
_BLOCK_BYTES = 1 << 24


@dataclass(frozen=True)
class CsvChunk:
    """Byte range of a CSV.

    Attributes:
        path: path of the file.
        begin: first byte, at the start of a line.
        end: one past the last byte.
        level: number of the level, the file's index among the sources of the map.
    """

    path: Path
    begin: int
    end: int
    level: int


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file; raises `DotMapError`."""
    digest = hashlib.sha256()
    try:
        with path.open('rb') as file:
            while block := file.read(_BLOCK_BYTES):
                digest.update(block)
    except OSError as fault:
        raise DotMapError(f'{path}: cannot be read ({fault.strerror}); give a dot map as CSV') from fault
    return digest.hexdigest()


def split_csv(path: Path, level: int, chunk_bytes: int) -> list[CsvChunk]:
    """Split the lines after the header into chunks of about ``chunk_bytes``; raises `DotMapError`."""
    try:
        with path.open('rb') as file:
            head = file.readline(_MAX_LINE_BYTES)
            check_header(path, head)
            size = path.stat().st_size
            begin, chunks = len(head), []
            while begin < size:
                file.seek(min(begin + chunk_bytes, size))
                end = file.tell() + len(file.readline())
                chunks.append(CsvChunk(path, begin, end, level))
                begin = end
    except OSError as fault:
        raise DotMapError(f'{path}: cannot be read ({fault.strerror}); give a dot map as CSV') from fault
    return chunks


def read_chunk(chunk: CsvChunk) -> Floats:
    """Return a chunk's dots, (n, 3): x, y, diameter or NaN [m]; raise a DotMapError for a malformed line."""
    with chunk.path.open('rb') as file:
        file.seek(chunk.begin)
        content = file.read(chunk.end - chunk.begin)
    table = _parse_fast(content)
    if table is None:
        lines_before = _count_lines(chunk.path, chunk.begin)
        rows = [line.strip() for line in content.decode('utf-8', 'replace').split('\n')]
        numbers = [number for number, row in enumerate(rows, start=lines_before + 1) if row]
        table = parse_rows(chunk.path, [row for row in rows if row], numbers)
    check_dots(
        table[:, :2],
        table[:, 2],
        str(chunk.path),
        lambda dot: f'line {_count_lines(chunk.path, chunk.begin) + dot + 1}',
    )
    return table


def _parse_fast(content: bytes) -> Floats | None:
    """Return the table of a chunk with the fast parser, None if it must be parsed line by line."""
    if b'n' in content or b'N' in content or b'\r' in content:
        return None
    filled = content.replace(b',\n', b',nan\n')
    try:
        table = np.loadtxt(io.BytesIO(filled), delimiter=',', comments=None, ndmin=2, encoding='ascii')
    except (ValueError, UnicodeDecodeError):
        return None
    return table if table.shape == (content.count(b'\n'), 3) else None


def _count_lines(path: Path, end: int) -> int:
    """Return the number of lines before a byte of a file."""
    count = 0
    with path.open('rb') as file:
        while end > 0:
            block = file.read(min(_BLOCK_BYTES, end))
            count += block.count(b'\n')
            end -= len(block)
    return count
