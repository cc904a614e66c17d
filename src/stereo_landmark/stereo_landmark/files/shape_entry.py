"""Converts primitives to and from file entries: the paper's shape parameters (3.3c) by name."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from stereo_landmark.core.primitives.corner import Corner
from stereo_landmark.core.primitives.ellipse import Ellipse
from stereo_landmark.core.primitives.parallel_lines import ParallelLines
from stereo_landmark.core.primitives.quadrilateral import Quadrilateral
from stereo_landmark.core.procedure.primitive import Primitive, PrimitiveKind
from stereo_landmark.core.procedure.taught_place import TaughtPrimitive

_TYPES: dict[PrimitiveKind, tuple[type[Primitive], int]] = {
    PrimitiveKind.ELLIPSE: (Ellipse, 5),
    PrimitiveKind.QUADRILATERAL: (Quadrilateral, 8),
    PrimitiveKind.PARALLEL_LINES: (ParallelLines, 3),
    PrimitiveKind.CORNER: (Corner, 2),
}
"""Class of each kind and size of its covariance matrix, which is not stored."""


def primitive_entry(taught: TaughtPrimitive) -> dict[str, Any]:
    """Return the file entry of a primitive."""
    names = [field.name for field in dataclasses.fields(taught.shape) if field.name != 'covariance']
    shape = {name: getattr(taught.shape, name) for name in names}
    entry = {'name': taught.name, 'kind': taught.kind.value, 'position': taught.position, 'shape': shape}
    return entry if taught.normal is None else {**entry, 'normal': taught.normal}


def primitive_from_entry(entry: dict[str, Any]) -> TaughtPrimitive:
    """Return the primitive of an entry that passed the schema check."""
    kind, rows = _TYPES[PrimitiveKind(entry['kind'])]
    values = {name: _number_or_array(name, value) for name, value in entry['shape'].items()}
    shape = kind(**values, covariance=np.zeros((rows, rows)))
    normal = np.array(entry['normal'], dtype=np.float64) if 'normal' in entry else None
    return TaughtPrimitive(entry['name'], shape, np.array(entry['position'], dtype=np.float64), normal)


def _number_or_array(name: str, value: Any) -> Any:
    if isinstance(value, list):
        return np.array(value, dtype=np.float64)
    return value if name == 'polarity' else float(value)
