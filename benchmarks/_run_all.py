"""All benchmarks one after the other, or the tables of the pages: `./shirube bench --all [--quick]`, `--tables`."""

import argparse
import subprocess
import sys
import time
from pathlib import Path

from _harness import children_cpu_seconds
from _results import OUT, pages, update_tables

FOLDER = Path(__file__).parent


def main() -> int:
    """Run what is asked for; return 1 when a benchmark fails or became worse."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--all', action='store_true', help='run all benchmarks, each as a program of its own')
    parser.add_argument('--tables', action='store_true', help='make the marked tables from the results')
    for flag in ('--quick', '--save', '--compare'):
        parser.add_argument(flag, action='store_true', help='passed to the benchmarks')
    options = parser.parse_args()
    if options.tables:
        write_tables()
    flags = [f'--{flag}' for flag in ('quick', 'save', 'compare') if getattr(options, flag)]
    return run_all(flags) if options.all else 0


def write_tables() -> None:
    """Make the marked tables anew."""
    for page in pages():
        text = page.read_text()
        if (updated := update_tables(text)) != text:
            page.write_text(updated)
            print(page)


def run_all(flags: list[str]) -> int:
    """Run every benchmark and print a line for each; what they print is kept in ``out/bench``."""
    OUT.mkdir(parents=True, exist_ok=True)
    begin, failed = time.perf_counter(), 0
    for program in sorted(FOLDER.glob('[!_]*.py')):
        start, before = time.perf_counter(), children_cpu_seconds()
        command = [sys.executable, str(program), *flags]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        (OUT / f'{program.stem}.log').write_text(done.stdout)
        failed += done.returncode != 0
        seconds, used = time.perf_counter() - start, children_cpu_seconds() - before
        print(f'{program.stem:<20} {seconds:6.1f} s, {used:6.1f} s CPU  {_verdict(done)}', flush=True)
    seconds = time.perf_counter() - begin
    print(f'{"all":<20} {seconds:6.1f} s, {children_cpu_seconds():6.1f} s CPU  {failed} failed or worse')
    return 1 if failed else 0


def _verdict(done: subprocess.CompletedProcess[str]) -> str:
    lines = done.stdout.strip().splitlines() or ['']
    skipped = next((line for line in lines if line.startswith('skipped: ')), '')
    if skipped:
        return skipped
    changed = next((line for line in lines if line.startswith('Since ')), '')
    if done.returncode == 0:
        return f'ok  {changed}'
    return f'worse  {changed}' if changed else f'failed: {lines[-1]}'


if __name__ == '__main__':
    raise SystemExit(main())
