"""From the light of a scene to grey levels: lamps and lens, then the sensor."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import PinholeCamera


@dataclass(frozen=True)
class Lighting:
    """Illumination by the camera's lamps, and lens losses.

    Attributes:
        level: grey level of a white floor in the middle of the image, 1 saturates.
        gradient: relative change from the middle to the right and to the lower edge.
        vignetting: relative loss in the corners.
        blur: standard deviation of the lens's point-spread function [px].
    """

    level: float = 0.9
    gradient: tuple[float, float] = (0.12, -0.08)
    vignetting: float = 0.3
    blur: float = 0.6

    def field(self, camera: PinholeCamera) -> NDArray[np.float32]:
        """Return the brightness of a white floor over the image, shape (height, width)."""
        u = np.linspace(-1.0, 1.0, camera.width)[None, :]
        v = np.linspace(-1.0, 1.0, camera.height)[:, None]
        slope = 1.0 + self.gradient[0] * u + self.gradient[1] * v
        return np.asarray(
            self.level * slope * (1.0 - self.vignetting * (u**2 + v**2) / 2.0), dtype=np.float32
        )

    def spread(self, light: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return an image, shape (height, width, channels), as the lens blurs it."""
        if self.blur == 0.0:
            return light
        blurred = cv2.GaussianBlur(light, (0, 0), self.blur, borderType=cv2.BORDER_REPLICATE)
        return np.asarray(blurred, dtype=np.float32).reshape(light.shape)


@dataclass(frozen=True)
class Sensor:
    """A sensor that counts electrons.

    Attributes:
        full_well: electrons at saturation; their random arrival is the shot noise.
        read_noise: standard deviation of the read-out [electrons].
    """

    full_well: float = 9000.0
    read_noise: float = 12.0

    def expose(self, light: NDArray[np.float32], rng: np.random.Generator | None) -> NDArray[np.uint8]:
        """Return 8-bit grey levels.

        Args:
            light: any shape, 1 saturates.
            rng: source of the noise, none for an ideal sensor.

        Returns:
            array of the same shape.
        """
        levels = light
        if rng is not None:
            electrons = np.maximum(light, 0.0) * self.full_well
            noise = rng.standard_normal(light.shape, dtype=np.float32)
            levels = light + noise * np.sqrt(electrons + self.read_noise**2) / self.full_well
        return np.clip(np.rint(255.0 * levels), 0.0, 255.0).astype(np.uint8)
