"""Names and docstrings use the words of the field: what a robotics engineer would type into a search box."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

pytestmark = [pytest.mark.quick, pytest.mark.newest_set_only]

ROOT = Path(__file__).resolve().parents[1]
FILES = [
    path
    for folder in ('src', 'benchmarks', 'environment')
    for path in sorted((ROOT / folder).rglob('*.py'))
    if 'test' not in path.parts
]
PRIVATE_WORDS = re.compile(
    r'(?:^|_)(?:tell|tells|told|mend|mends|mended|suppose|supposed|supposition|shelf|shelve|shelved|piece|pieces'
    r'|witness|witnessed|sighting|sightings|ears|voice|speaks|stands|lasting|creep|doubts|patience|stranger|rehearsal'
    r'|anew|heard|hearing|beside|spoilt|ghost|ghosts|moved_on|way_back)(?:_|$)'
)
"""Words of our own that readers had to look up; docs/glossary.md has the field's."""
ENTRY = re.compile(r'^    (\*{0,2}\w[\w, *]*?)(?: \([^)]*\))?: (\S.*)$')
SECTION = re.compile(r'^(?:Args|Attributes|Raises|Returns|Yields):\s*$')
PREPOSITION = re.compile(
    r'^(?:of|in|at|from|to|for|by|with|on|as|between|under|over|within|without|behind|before|after|above|below|beside'
    r'|along|across|near|around|into|through|towards?|against|among)\b'
)


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


def words_of(name: str) -> str:
    """Return a name in lower case with underscores between its words."""
    return re.sub(r'(?<=[a-z0-9])(?=[A-Z])', '_', name).lower()


def definitions(path: Path) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef]:
    for node in ast.walk(parsed(path)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield node


def entries(docstring: str) -> Iterator[str]:
    """Yield the description of each argument, attribute, result and error of a docstring."""
    inside = False
    for line in docstring.splitlines():
        if SECTION.match(line):
            inside = True
        elif line and not line.startswith(' '):
            inside = False
        elif inside and (match := ENTRY.match(line)):
            yield match[2]


def test_the_rules_notice_private_words() -> None:
    assert all(PRIVATE_WORDS.search(words_of(name)) for name in ('tellPose', 'MissionEars', 'mended', 'is_told'))
    assert not any(PRIVATE_WORDS.search(words_of(name)) for name in ('predict', 'intellect', 'Recommended'))
    text = 'Do it.\n\nArgs:\n    radius: of the wheel [m].\n    width: distance [m].\n\nReturns:\n    the sum.\n'
    assert [bool(PREPOSITION.match(entry)) for entry in entries(text)] == [True, False]


def test_names_are_of_the_field() -> None:
    names = [
        f'{path.relative_to(ROOT)}:{node.lineno} {node.name}'
        for path in FILES
        for node in definitions(path)
        if PRIVATE_WORDS.search(words_of(node.name))
    ]
    assert not names


def test_docstring_entries_name_the_quantity() -> None:
    fragments = [
        f'{path.relative_to(ROOT)}:{node.lineno} {entry}'
        for path in FILES
        for node in (parsed(path), *definitions(path))
        for entry in entries(ast.get_docstring(node) or '')
        if PREPOSITION.match(entry)
    ]
    assert not fragments
