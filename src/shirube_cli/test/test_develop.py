"""When the whole suite runs, what it needs is made before: the time of a single test is limited."""

from pathlib import Path

import pytest

from shirube_cli import develop


@pytest.fixture
def calls(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, list]:
    """What was built, and the arguments that pytest got."""
    (tmp_path / 'tests').mkdir()
    (tmp_path / 'tests/test_one.py').touch()
    made: dict[str, list] = {'built': [], 'pytest': []}
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv('NUMBA_CACHE_DIR', str(tmp_path))
    monkeypatch.setattr(develop, 'find_root', lambda: tmp_path)
    monkeypatch.setattr(develop, 'install_development_packages', lambda: None)
    monkeypatch.setattr(develop, 'build_workspace', made['built'].append)
    monkeypatch.setattr(develop, 'compiled_kernels', lambda root: root)
    monkeypatch.setattr(develop, 'kernel_folder', lambda root: root)
    monkeypatch.setattr(develop, 'run_tool', lambda tool, given: made[tool].extend(given) or 0)
    return made


@pytest.mark.parametrize(
    ('arguments', 'is_whole', 'is_parallel'),
    [
        ('', True, True),
        ('-x -k pose', True, True),
        ('-m newest_set_only', True, True),
        ('-n2 --dist worksteal', True, False),
        ('--pdb', True, False),
        ('--quick -x', False, True),
        ('tests', False, False),
        ('-q tests/test_one.py::test_it', False, False),
    ],
)
def test_the_whole_suite_is_built_before_and_uses_all_cores_unless_told_otherwise(
    tmp_path: Path, calls: dict[str, list], arguments: str, is_whole: bool, is_parallel: bool
) -> None:
    assert develop.run_tests(arguments.split()) == 0
    assert calls['built'] == ([tmp_path] if is_whole else [])
    options = develop.parallel_options() if is_parallel else []
    assert calls['pytest'] == [*options, *arguments.replace('--quick', '-m quick').split()]
