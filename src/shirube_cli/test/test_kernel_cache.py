"""The loops are compiled in parts that exist, and machine code of other sources goes."""

from pathlib import Path

from floor_localizer.core.warm_up import PARTS
from shirube_cli.kernel_cache import WARM_UP_PARTS, digest_loops, fresh_cache


def test_all_parts_of_the_warm_up_are_compiled() -> None:
    assert set(WARM_UP_PARTS) == set(PARTS)


def test_only_the_cache_of_these_sources_stays(tmp_path: Path) -> None:
    for name in ('0' * 16, '1' * 16):
        (tmp_path / name).mkdir()
    cache = fresh_cache(tmp_path, '1' * 64)
    assert cache == tmp_path / ('1' * 16)
    assert sorted(tmp_path.iterdir()) == [cache]


def test_the_digest_sees_loops_and_what_goes_into_them_and_nothing_else(tmp_path: Path) -> None:
    package = tmp_path / 'robot' / 'robot'
    package.mkdir(parents=True)
    files = {
        'loops.py': 'from robot.constants import REACH\n\n\n@njit(cache=True)\ndef reach():\n    return REACH\n',
        'constants.py': 'REACH = 1\n',
        'words.py': 'HELLO = 1\n',
    }
    digests = []
    for changed in (None, *files):
        for name, text in files.items():
            (package / name).write_text(text + '# changed\n' * (name == changed))
        digests.append(digest_loops(tmp_path))
    untouched, loops, constants, words = digests
    assert words == untouched
    assert len({untouched, loops, constants}) == 3
