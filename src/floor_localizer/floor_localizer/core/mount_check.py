"""Whether the camera, as mounted, sees the floor."""

from floor_localizer.core.errors import FloorLocalizerError
from shirube_core.geometry import CameraMount

# Smallest sine of the angle by which the optical axis points below the horizon.
_MIN_SLOPE = 0.1


def check_mount(mount: CameraMount) -> None:
    """Raise a FloorLocalizerError for a camera below the floor or one that does not look at it."""
    height = mount.xyz[2]
    if height <= 0.0:
        raise FloorLocalizerError(
            f'camera_xyz: z is {height:g} m, it must be above the floor, which is the plane z = 0 of base_frame'
        )
    if -mount.rotation[2, 2] < _MIN_SLOPE:
        raise FloorLocalizerError(
            f'camera_rpy: {", ".join(f"{angle:g}" for angle in mount.rpy)} rad does not look at the floor; '
            f'{", ".join(f"{angle:.4f}" for angle in CameraMount().rpy)} looks straight down'
        )
