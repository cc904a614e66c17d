"""A CSV dot map read in pieces: ranges of bytes that end with a line."""

from __future__ import annotations

import hashlib
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from floor_localizer.files.csv_form import check_header, parse_rows
from floor_localizer.files.dot_map_check import check_dots
from floor_localizer.files.file_errors import DotMapError

# Longer than any line of a dot map.
_LINE = 1 << 12
_BLOCK = 1 << 24


@dataclass(frozen=True)
class CsvPiece:
    """A range of bytes of a CSV.

    Attributes:
        path: of the file.
        begin: first byte; the first line of the piece begins there.
        end: one past its last byte.
        sheet: number of the file among the map's.
    """

    path: Path
    begin: int
    end: int
    sheet: int


def digest_of(path: Path) -> str:
    """Return the SHA-256 of a file.

    Raises:
        DotMapError: it cannot be read.
    """
    digest = hashlib.sha256()
    try:
        with path.open('rb') as file:
            while block := file.read(_BLOCK):
                digest.update(block)
    except OSError as fault:
        raise DotMapError(f'{path}: cannot be read ({fault.strerror}); give a dot map as CSV') from fault
    return digest.hexdigest()


def split_csv(path: Path, sheet: int, piece_bytes: int) -> list[CsvPiece]:
    """Split the lines after the header into pieces of about so many bytes.

    Raises:
        DotMapError: the file cannot be read, or its header is not that of a dot map.
    """
    try:
        with path.open('rb') as file:
            head = file.readline(_LINE)
            check_header(path, head)
            size = path.stat().st_size
            begin, pieces = len(head), []
            while begin < size:
                file.seek(min(begin + piece_bytes, size))
                end = file.tell() + len(file.readline())
                pieces.append(CsvPiece(path, begin, end, sheet))
                begin = end
    except OSError as fault:
        raise DotMapError(f'{path}: cannot be read ({fault.strerror}); give a dot map as CSV') from fault
    return pieces


def read_piece(piece: CsvPiece) -> NDArray[np.float64]:
    """Return the dots of a piece, shape (n, 3): x, y and diameter [m], NaN where that is unknown.

    Raises:
        DotMapError: a line is malformed, or a number is not one that a dot can have.
    """
    with piece.path.open('rb') as file:
        file.seek(piece.begin)
        content = file.read(piece.end - piece.begin)
    table = _parse_at_once(content)
    if table is None:
        lines_before = _count_lines(piece.path, piece.begin)
        rows = [line.strip() for line in content.decode('utf-8', 'replace').split('\n')]
        numbers = [number for number, row in enumerate(rows, start=lines_before + 1) if row]
        table = parse_rows(piece.path, [row for row in rows if row], numbers)
    check_dots(
        table[:, :2],
        table[:, 2],
        str(piece.path),
        lambda dot: f'line {_count_lines(piece.path, piece.begin) + dot + 1}',
    )
    return table


def _parse_at_once(content: bytes) -> NDArray[np.float64] | None:
    """Return the table of a piece of plain lines, None where it must be looked at line by line."""
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
            block = file.read(min(_BLOCK, end))
            count += block.count(b'\n')
            end -= len(block)
    return count
