"""What benchmarks found: JSON files, comparison with the kept result, tables of the Markdown pages."""

import json
import os
import platform
import re
import subprocess
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from itertools import takewhile
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from _figures import Change, Figure, changes, figure_from_json

ROOT = Path(__file__).resolve().parents[1]
RESULTS = Path(__file__).with_name('results')
OUT = ROOT / 'out' / 'bench'
MARKED = re.compile(r'(<!-- bench (\S+?)/(.+?)( quick)? -->\n).*?(<!-- end -->)', re.DOTALL)
"""A table that is made from a result: benchmark, table, and whether it is that of a quick run."""

Cell = Figure | str


def machine() -> dict[str, Any]:
    """Return commit and date, and what the figures depend on."""
    commit = _git('rev-parse', '--short=10', 'HEAD')
    return {
        'commit': commit + ('+' if _git('status', '--porcelain', '--', 'src', 'benchmarks/*.py') else ''),
        'date': datetime.now(UTC).strftime('%Y-%m-%d'),
        'machine': {
            'cpu': _cpu(),
            'cores': os.cpu_count(),
            'load': round(os.getloadavg()[0], 1),
            'python': platform.python_version(),
            'numpy': np.__version__,
            'opencv': cv2.__version__,
        },
    }


def _git(*arguments: str) -> str:
    found = subprocess.run(['git', *arguments], cwd=ROOT, capture_output=True, text=True, check=False)
    return found.stdout.strip()


def _cpu() -> str:
    path = Path('/proc/cpuinfo')
    lines = path.read_text().splitlines() if path.exists() else []
    names = (line.partition(': ')[2] for line in lines if line.startswith('model name'))
    return next(names, platform.machine())


def write_json(found: dict[str, Any]) -> None:
    """Write a result to ``out/bench/<name>.json``."""
    path = OUT / f'{found["benchmark"]}.json'
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(as_json(found))


def save(found: dict[str, Any], *, quick: bool) -> None:
    """Keep a result in ``benchmarks/results/<name>.json``; full and quick runs stand side by side."""
    path = RESULTS / f'{found["benchmark"]}.json'
    path.parent.mkdir(exist_ok=True)
    kept = json.loads(path.read_text()) if path.exists() else {}
    kept['quick' if quick else 'full'] = json.loads(as_json(found))
    path.write_text(as_json({key: kept[key] for key in ('full', 'quick') if key in kept}))


def as_json(found: dict[str, Any]) -> str:
    """Return a result as JSON, a line a row of a table."""
    plain = json.loads(json.dumps(found, default=_plain, allow_nan=False))
    rows: list[str] = []

    def mark(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: mark(part) for key, part in value.items()}
        if isinstance(value, list) and value and isinstance(value[0], list):
            rows.extend(json.dumps(row, ensure_ascii=False) for row in value)
            return [f'@{len(rows) - len(value) + k}@' for k in range(len(value))]
        return [mark(part) for part in value] if isinstance(value, list) else value

    text = json.dumps(mark(plain), indent=1, ensure_ascii=False)
    return re.sub(r'"@(\d+)@"', lambda found: rows[int(found[1])], text) + '\n'


def _plain(value: Any) -> Any:
    if isinstance(value, Figure):
        return value.as_json()
    if isinstance(value, np.generic):
        return value.item()
    return {'name': value.name, 'heads': value.heads, 'rows': value.rows}


def load_saved(name: str, *, quick: bool) -> dict[str, Any] | None:
    """Return the kept result of a benchmark, None where there is none."""
    path = RESULTS / f'{name}.json'
    kept = json.loads(path.read_text()) if path.exists() else {}
    return kept.get('quick' if quick else 'full')


def figures_of(found: dict[str, Any]) -> Iterator[tuple[tuple[str, ...], Figure]]:
    """Yield the figures of a result that was read from JSON, by table, row and column."""
    for table in found['tables']:
        seen: set[tuple[str, ...]] = set()
        for row in table['rows']:
            names = tuple(takewhile(lambda cell: isinstance(cell, str), row))
            for head, cell in zip(table['heads'], row, strict=True):
                if isinstance(cell, dict):
                    key = (table['name'], *names, head)
                    while key in seen:
                        key = (*key, 'again')
                    seen.add(key)
                    yield key, figure_from_json(cell)


def compare(before: dict[str, Any], after: dict[str, Any]) -> list[tuple[tuple[str, ...], Change]]:
    """Return the figures of two results, read from JSON, that differ."""
    old, new = dict(figures_of(before)), dict(figures_of(after))
    return [(key, change) for key in new if key in old for change in changes(old[key], new[key])]


def compare_with_saved(found: dict[str, Any], *, quick: bool) -> int:
    """Print what changed since the kept result; return how many figures are worse."""
    before, after = load_saved(found['benchmark'], quick=quick), json.loads(as_json(found))
    if before is None:
        print('\nNo kept result to compare with: run it with --save.')
        return 0
    if before['arguments'] != after['arguments']:
        print('\nOther arguments than the kept result has: not compared.')
        return 0
    differing = compare(before, after)
    print(f'\nSince {before["commit"]} ({before["date"]}): {len(differing)} figures changed.')
    for key, change in differing:
        name = f'{" | ".join(key)} {change.name}'
        print(f'  {change.verdict}: {name}: {change.before:.5g} -> {change.after:.5g}')
    new, old = (dict(figures_of(each)) for each in (after, before))
    for word, keys in (('new', new.keys() - old.keys()), ('gone', old.keys() - new.keys())):
        if keys:
            print(f'  {word}: {len(keys)} figures')
    return sum(change.verdict == 'worse' for _, change in differing)


def format_table(heads: Sequence[str], rows: Sequence[Sequence[Cell | dict[str, Any]]]) -> str:
    """Return an aligned table as Markdown."""
    lines = [list(heads), *([_text(cell) for cell in row] for row in rows)]
    widths = [max(len(line[k]) for line in lines) for k in range(len(heads))]
    lines.insert(1, ['-' * width for width in widths])
    aligned = ([cell.ljust(width) for cell, width in zip(line, widths, strict=True)] for line in lines)
    return '\n'.join(f'| {" | ".join(line)} |' for line in aligned) + '\n'


def _text(cell: Cell | dict[str, Any]) -> str:
    if isinstance(cell, Figure):
        return cell.text
    return str(cell['text']) if isinstance(cell, dict) else cell


def pages() -> list[Path]:
    """Return the Markdown pages that may have tables made from results."""
    folders = (ROOT, ROOT / 'benchmarks', ROOT / 'docs', *(ROOT / 'src').glob('*'))
    return sorted(page for folder in folders for page in folder.glob('*.md'))


def update_tables(page: str) -> str:
    """Return the text of a page with its marked tables made anew.

    Raises:
        KeyError: a marker names a table that no kept result has.
    """

    def table_of(found: re.Match[str]) -> str:
        begin, name, wanted, quick, end = found.groups()
        kept = load_saved(name, quick=bool(quick))
        tables = {} if kept is None else {table['name']: table for table in kept['tables']}
        if kept is None or wanted not in tables:
            raise KeyError(f'no kept{quick or ""} result of {name} has the table {wanted!r}')
        table = tables[wanted]
        text = format_table(table['heads'], table['rows'])
        return f'{begin}\n{text}\nPrinted at `{kept["commit"]}`, {kept["date"]}{_arguments(kept)}.\n\n{end}'

    return MARKED.sub(table_of, page)


def _arguments(kept: dict[str, Any]) -> str:
    shown = [f'{key} {value}' for key, value in kept['arguments'].items() if key != 'seed' and value != '']
    return f' ({", ".join(shown)})' if shown else ''
