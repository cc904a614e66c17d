"""Converts numpy arrays and scalars to types that YAML supports."""

from __future__ import annotations

from typing import Any

import numpy as np


def to_plain(content: Any) -> Any:
    """Return nested content with lists instead of arrays and tuples, and Python numbers, without loss of precision."""
    if isinstance(content, dict):
        return {name: to_plain(value) for name, value in content.items()}
    if isinstance(content, (list, tuple)):
        return [to_plain(value) for value in content]
    return content.tolist() if isinstance(content, (np.ndarray, np.generic)) else content
