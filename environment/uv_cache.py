"""The folder in which uv keeps what it downloads."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def private_cache(folder: Path) -> Iterator[dict[str, str]]:
    """Give uv a cache inside the environment where the user's own cannot be written; it goes afterwards."""
    if 'UV_CACHE_DIR' in os.environ or is_writable(cache_home()):
        yield {}
        return
    cache = folder / 'uv-cache'
    try:
        yield {'UV_CACHE_DIR': str(cache)}
    finally:
        shutil.rmtree(cache, ignore_errors=True)


def cache_home() -> Path:
    """Return the folder in which uv keeps what it downloads."""
    return Path(os.environ.get('XDG_CACHE_HOME') or Path('~/.cache').expanduser()) / 'uv'


def is_writable(folder: Path) -> bool:
    """Return whether a folder exists or can be made, and can be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):
        return False
    return os.access(folder, os.W_OK | os.X_OK)


def shares_disk(folder: Path) -> bool:
    """Return whether uv can link files of its cache into a folder instead of copying them."""
    cache = cache_home()
    return cache.exists() and cache.stat().st_dev == folder.stat().st_dev
