"""Settings of a mat and of the pages it is printed on."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class MatSettings:
    """The dots of a mat."""

    width: float = setting(
        0.0, 'width of the mat along x; 0 fills one page', unit='m', minimum=0.0, maximum=20.0
    )
    height: float = setting(
        0.0, 'height of the mat along y; 0 fills one page', unit='m', minimum=0.0, maximum=20.0
    )
    density: float = setting(5000.0, 'dots per square metre', unit='1/m^2', minimum=50.0, maximum=100_000.0)
    diameter: float = setting(0.0025, 'diameter of a dot', unit='m', minimum=0.0005, maximum=0.05)
    spacing: float = setting(
        0.004, 'smallest distance between the centres of two dots', unit='m', minimum=0.0005, maximum=0.2
    )


@dataclass(frozen=True)
class PageSettings:
    """The paper."""

    margin: float = setting(
        0.012, 'margin of each page, which contains the marks', unit='m', minimum=0.01, maximum=0.05
    )
    overlap: float = setting(
        0.01, 'overlap of two pages that are glued together', unit='m', minimum=0.0, maximum=0.05
    )
    roll_width: float = setting(0.914, 'width of the roll', unit='m', minimum=0.1, maximum=5.0)
