"""The loops are compiled in parts that exist, and machine code of other sources goes."""

from pathlib import Path

from floor_localizer.core.warm_up import PARTS
from shirube_cli.kernel_cache import WARM_UP_PARTS, fresh_cache


def test_all_parts_of_the_warm_up_are_compiled() -> None:
    assert set(WARM_UP_PARTS) == set(PARTS)


def test_only_the_cache_of_these_sources_stays(tmp_path: Path) -> None:
    for name in ('0' * 16, '1' * 16):
        (tmp_path / name).mkdir()
    cache = fresh_cache(tmp_path, '1' * 64)
    assert cache == tmp_path / ('1' * 16)
    assert sorted(tmp_path.iterdir()) == [cache]
