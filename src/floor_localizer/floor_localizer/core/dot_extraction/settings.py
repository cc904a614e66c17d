"""Settings of dot extraction."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class DotDetectorSettings:
    """What counts as a dot. Lengths are pixels or parts of the typical dot of the image at hand."""

    polarity: str = setting(
        'auto',
        'which dots are sought: darker or lighter than the floor, any that differ in brightness or colour, '
        'or auto to choose one of these from each image',
        choices=('auto', 'dark', 'light', 'any'),
    )
    minimum_diameter: float = setting(
        3.0, 'diameter of the smallest dot kept', unit='px', minimum=2.0, maximum=500.0
    )
    maximum_diameter: float = setting(
        0.0,
        'diameter of the largest dot kept; 0 takes 5 % of the longer image side, at least 25 px',
        unit='px',
        minimum=0.0,
        maximum=1000.0,
    )
    minimum_relative_diameter: float = setting(
        0.4, 'diameter of the smallest dot kept as a part of the typical dot', minimum=0.0, maximum=1.0
    )
    minimum_relative_contrast: float = setting(
        0.3,
        'contrast of a pixel that may belong to a dot as a part of the typical dot',
        minimum=0.1,
        maximum=0.8,
    )
    noise_sigmas: float = setting(
        5.0,
        'contrast of a pixel that may belong to a dot in standard deviations of the floor',
        minimum=2.0,
        maximum=20.0,
    )
    maximum_elongation: float = setting(
        4.0, 'largest ratio of length to width, motion blur taken out', minimum=1.5, maximum=100.0
    )

    def largest_diameter(self, width: int, height: int) -> float:
        """Return the diameter of the largest dot kept in an image of this size [px]."""
        return self.maximum_diameter or max(25.0, 0.05 * max(width, height))
