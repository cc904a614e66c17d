"""What became of one image when images are located without a running node."""

from __future__ import annotations

from dataclasses import dataclass

from floor_localizer.core.fix import Fix, NoFix


@dataclass(frozen=True)
class LocatedImage:
    """One image and its result.

    Attributes:
        name: of its file, or of its topic.
        stamp_ns: when it was taken [ns]; for files their number in seconds.
        result: the pose, the reason why there is none, or the message of the error that the image raised.
    """

    name: str
    stamp_ns: int
    result: Fix | NoFix | str

    @property
    def failure(self) -> str:
        """Why there is no pose, empty if there is one."""
        if isinstance(self.result, Fix):
            return ''
        return self.result if isinstance(self.result, str) else self.result.reason.value
