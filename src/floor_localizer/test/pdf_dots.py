"""A reader of PDF pages of its own: where filled shapes without straight lines lie, in millimetres."""

import re
import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_POINT = 25.4 / 72.0
_TOKEN = re.compile(rb'\((?:\\.|[^)\\])*\)|<[0-9A-Fa-f\s]*>|\[[^\]]*\]|[^\s\[\]()<>]+')


@dataclass(frozen=True)
class PdfPage:
    """Size of a page, and middles and diameters of its round shapes [mm], from the lower left corner."""

    size: tuple[float, float]
    middles: NDArray[np.float64]
    diameters: NDArray[np.float64]
    strings: bytes


def read_pages(data: bytes) -> list[PdfPage]:
    objects = {int(n): body for n, body in re.findall(rb'(?:^|\n)(\d+) 0 obj\n(.*?)\nendobj', data, re.DOTALL)}
    pages = []
    for body in objects.values():
        if b'/Type /Page\n' in body + b'\n' or re.search(rb'/Type /Page[^s]', body):
            box = [float(x) for x in re.search(rb'/MediaBox \[([^\]]*)\]', body)[1].split()]
            content = _stream(objects[int(re.search(rb'/Contents (\d+)', body)[1])])
            forms = _forms(objects, body)
            middles, diameters = _shapes(content, forms)
            size = ((box[2] - box[0]) * _POINT, (box[3] - box[1]) * _POINT)
            pages.append(PdfPage(size, middles, diameters, _strings(content)))
    return pages


def _stream(body: bytes) -> bytes:
    raw = body.split(b'stream\n', 1)[1].rsplit(b'\nendstream', 1)[0]
    return zlib.decompress(raw) if b'/FlateDecode' in body else raw


def _forms(objects: dict[int, bytes], page: bytes) -> dict[bytes, bytes]:
    """Return the page's form XObjects by name."""
    resources = objects[int(re.search(rb'/Resources (\d+)', page)[1])] if b'/Resources ' in page else page
    entry = re.search(rb'/XObject (\d+) 0 R', resources)
    table = objects[int(entry[1])] if entry else b''
    return {name: _stream(objects[int(number)]) for name, number in re.findall(rb'/(\w+) (\d+) 0 R', table)}


def _shapes(content: bytes, forms: dict[bytes, bytes]) -> tuple[NDArray, NDArray]:
    found: list[tuple[float, float, float]] = []
    _run(content, np.eye(3), forms, found)
    table = np.array(found).reshape(-1, 3) * _POINT
    return table[:, :2], table[:, 2]


def _run(content: bytes, matrix: NDArray, forms: dict[bytes, bytes], found: list) -> None:
    stack, operands, path, lines, name = [matrix], [], [], 0, b''
    for token in _TOKEN.findall(content):
        if re.fullmatch(rb'[-+]?\d*\.?\d+', token):
            operands.append(float(token))
            continue
        if token == b'q':
            stack.append(stack[-1])
        elif token == b'Q':
            stack.pop()
        elif token == b'cm':
            a, b, c, d, e, f = operands[-6:]
            stack[-1] = stack[-1] @ np.array([[a, c, e], [b, d, f], [0, 0, 1]])
        elif token == b'Do':
            _run(forms[name], stack[-1], {}, found)
        elif token in (b'm', b'l'):
            path.append((*operands[-2:], 1.0))
            lines += token == b'l'
        elif token == b'c':
            path.append((*operands[-2:], 1.0))
        elif token in (b'f', b'f*', b'B', b'n', b'S', b'W'):
            if token in (b'f', b'B') and len(path) > 6 and lines == 0:
                corners = (stack[-1] @ np.array(path).T)[:2]
                lower, upper = corners.min(axis=1), corners.max(axis=1)
                found.append((*(0.5 * (lower + upper)), float(np.mean(upper - lower))))
            if token != b'W':
                path, lines = [], 0
        if token[:1] == b'/':
            name = token[1:]
        operands = []


def _strings(content: bytes) -> bytes:
    """Return the letters that are shown, as far as they are plain."""
    return b''.join(re.findall(rb'\(((?:\\.|[^)\\])*)\)', content))
