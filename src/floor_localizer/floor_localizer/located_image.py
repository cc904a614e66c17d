"""The result of one image that was located without a running node."""

from __future__ import annotations

from dataclasses import dataclass

from floor_localizer.core.fix import Fix, NoFix


@dataclass(frozen=True)
class LocatedImage:
    """One image and its result.

    Attributes:
        name: name of the file or topic.
        stamp_ns: time of the image [ns]; for files, their index in seconds.
        result: the pose, the reason for no pose, or the error message of the image.
    """

    name: str
    stamp_ns: int
    result: Fix | NoFix | str

    @property
    def failure(self) -> str:
        """Reason for no pose, empty if there is one."""
        if isinstance(self.result, Fix):
            return ''
        return self.result if isinstance(self.result, str) else self.result.reason.value
