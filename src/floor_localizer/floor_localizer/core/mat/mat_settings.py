"""What a mat and the sheets it is printed on are like."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class MatSettings:
    """The dots of a mat."""

    width: float = setting(0.0, 'of the mat along x; 0 fills one sheet', unit='m', minimum=0.0, maximum=20.0)
    height: float = setting(0.0, 'of the mat along y; 0 fills one sheet', unit='m', minimum=0.0, maximum=20.0)
    density: float = setting(5000.0, 'dots on a square metre', unit='1/m^2', minimum=50.0, maximum=100_000.0)
    diameter: float = setting(0.0025, 'of a dot', unit='m', minimum=0.0005, maximum=0.05)
    spacing: float = setting(
        0.004, 'no two dots have their centres nearer than this', unit='m', minimum=0.0005, maximum=0.2
    )


@dataclass(frozen=True)
class SheetSettings:
    """The paper."""

    margin: float = setting(
        0.012,
        'of each sheet, which holds the marks',
        unit='m',
        minimum=0.01,
        maximum=0.05,
    )
    overlap: float = setting(
        0.01, 'strip by which two sheets are glued over each other', unit='m', minimum=0.0, maximum=0.05
    )
    roll_width: float = setting(0.914, 'width of the roll', unit='m', minimum=0.1, maximum=5.0)
