"""Converts grouped settings to and from file entries."""

from __future__ import annotations

from functools import reduce
from typing import Any

from shirube_core.settings import describe_settings


def nest(settings: object) -> dict[str, Any]:
    """Return all values of a settings instance as nested entries, one per group."""
    entry: dict[str, Any] = {}
    for description in describe_settings(type(settings)):
        *groups, name = description.name.split('.')
        inner = reduce(lambda part, group: part.setdefault(group, {}), groups, entry)
        inner[name] = reduce(getattr, (*groups, name), settings)
    return entry


def flatten(entry: dict[str, Any], prefix: str = '') -> dict[str, object]:
    """Return the values of nested entries by their full names, ``group.name``."""
    values: dict[str, object] = {}
    for name, value in entry.items():
        if isinstance(value, dict):
            values |= flatten(value, f'{prefix}{name}.')
        else:
            values[f'{prefix}{name}'] = value
    return values
