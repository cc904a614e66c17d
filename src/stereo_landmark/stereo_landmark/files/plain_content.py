"""Arrays and numbers of numpy as what YAML knows."""

from __future__ import annotations

from typing import Any

import numpy as np


def plain(content: Any) -> Any:
    """Return a nested content with lists for arrays and tuples, and Python's own numbers; none loses a bit."""
    if isinstance(content, dict):
        return {name: plain(value) for name, value in content.items()}
    if isinstance(content, (list, tuple)):
        return [plain(value) for value in content]
    return content.tolist() if isinstance(content, (np.ndarray, np.generic)) else content
