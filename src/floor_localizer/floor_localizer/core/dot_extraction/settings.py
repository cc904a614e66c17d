"""Settings of dot extraction."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class DotDetectorSettings:
    """Criteria for a dot. Lengths are in pixels or fractions of the typical dot of the current image."""

    polarity: str = setting(
        'auto',
        'which dots are detected: darker or lighter than the floor, any that differ in brightness or colour, '
        'or auto to choose one of these for each image',
        choices=('auto', 'dark', 'light', 'any'),
    )
    minimum_diameter: float = setting(3.0, 'minimum diameter of a dot', unit='px', minimum=2.0, maximum=500.0)
    maximum_diameter: float = setting(
        0.0,
        'maximum diameter of a dot; 0 for 5 % of the longer image side, at least 25 px',
        unit='px',
        minimum=0.0,
        maximum=1000.0,
    )
    minimum_relative_diameter: float = setting(
        0.4, 'minimum diameter of a dot as a fraction of the typical diameter', minimum=0.0, maximum=1.0
    )
    minimum_relative_contrast: float = setting(
        0.3,
        'minimum contrast of a pixel of a dot as a fraction of the typical contrast',
        minimum=0.1,
        maximum=0.8,
    )
    noise_sigmas: float = setting(
        5.0,
        'minimum contrast of a pixel of a dot in standard deviations of the floor',
        minimum=2.0,
        maximum=20.0,
    )
    maximum_elongation: float = setting(
        4.0, 'maximum ratio of length to width, corrected for motion blur', minimum=1.5, maximum=100.0
    )

    def largest_diameter(self, width: int, height: int) -> float:
        """Return the maximum diameter of a dot in an image of this size [px]."""
        return self.maximum_diameter or max(25.0, 0.05 * max(width, height))
