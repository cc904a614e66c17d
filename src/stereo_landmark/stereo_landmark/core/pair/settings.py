"""How images become pairs."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class PairSettings:
    """Whether images come raw, and which of them belong together."""

    rectify: bool = setting(False, 'whether images come raw and are rectified here, by their camera_info')
    approximate_sync: bool = setting(
        False, 'whether images pair whose stamps differ a little; else only equal stamps do'
    )
    approximate_sync_tolerance_seconds: float = setting(
        0.01,
        'largest difference of stamps with approximate_sync; less than half the time between images',
        unit='s',
        minimum=0.0,
        maximum=1.0,
    )
    queue_size: int = setting(5, 'images of a camera that wait for their partner', minimum=1, maximum=1000)

    @property
    def tolerance_ns(self) -> int:
        """Largest difference of the stamps of a pair [ns]."""
        return round(self.approximate_sync_tolerance_seconds * 1e9) if self.approximate_sync else 0
