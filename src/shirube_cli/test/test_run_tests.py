"""When the whole suite runs, what it needs is made before: the time of a single test is limited."""

from pathlib import Path

import pytest

from shirube_cli import run_tests


@pytest.mark.parametrize(
    ('arguments', 'is_whole'),
    [
        ([], True),
        (['-n2', '--dist', 'worksteal'], True),
        (['-m', 'not newest_set_only'], True),
        (['tests'], False),
        (['-q', 'tests/test_one.py::test_it'], False),
    ],
)
def test_the_workspace_is_built_before_the_whole_suite_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], is_whole: bool
) -> None:
    (tmp_path / 'tests').mkdir()
    (tmp_path / 'tests/test_one.py').touch()
    built: list[Path] = []
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv('NUMBA_CACHE_DIR', str(tmp_path))
    monkeypatch.setattr(run_tests, 'find_root', lambda: tmp_path)
    monkeypatch.setattr(run_tests, 'build_workspace', built.append)
    monkeypatch.setattr(run_tests, 'compiled_loops', lambda root: root)
    monkeypatch.setattr(run_tests, 'loops_folder', lambda root: root)
    monkeypatch.setattr(run_tests, 'run_tool', lambda tool, given: 0)
    assert run_tests.run_tests(arguments) == 0
    assert built == ([tmp_path] if is_whole else [])
