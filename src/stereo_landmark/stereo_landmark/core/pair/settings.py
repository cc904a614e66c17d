"""Settings of stereo synchronization and rectification."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class PairSettings:
    """Rectification and synchronization of the image topics."""

    rectify: bool = setting(False, 'whether to rectify raw input images by their camera_info')
    approximate_sync: bool = setting(
        False, 'whether to pair images with slightly different stamps; otherwise stamps must be equal'
    )
    approximate_sync_tolerance_seconds: float = setting(
        0.01,
        'largest stamp difference of a pair with approximate_sync; less than half the frame interval',
        unit='s',
        minimum=0.0,
        maximum=1.0,
    )
    queue_size: int = setting(5, 'queue size per camera for synchronization', minimum=1, maximum=1000)

    @property
    def tolerance_ns(self) -> int:
        """Largest stamp difference of a pair [ns]."""
        return round(self.approximate_sync_tolerance_seconds * 1e9) if self.approximate_sync else 0
