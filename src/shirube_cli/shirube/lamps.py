"""IDs of blinking lamps, and the robot's pose under them."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from numpy.typing import ArrayLike

from shirube.inputs import InputError, as_camera, as_image, as_triple, prepare
from shirube.results import LampResult, as_pose
from shirube_core.geometry import CameraMount, PinholeCamera
from shirube_core.settings import check_settings
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.pose.pose_fix import BeaconFix, NoBeaconFix
from vlc_beacon.core.receiver.beacon_receiver import BeaconReceiver
from vlc_beacon.core.settings import AuthorizationSettings, ReceiverSettings
from vlc_beacon.files.beacons_file import load_beacons
from vlc_beacon.node_settings import NodeSettings, authorizer_from_settings

_RADIUS = 0.05  # radius of the bright disc of a lamp that is given by its position only [m]


def read(
    images: Iterable[ArrayLike],
    camera: PinholeCamera | str | Path,
    lamps: str | Path | Mapping[int, Sequence[float]] | None = None,
    *,
    rate: float = 60.0,
    light: ReceiverSettings | None = None,
    camera_xyz: Sequence[float] = NodeSettings.camera_xyz,
    camera_rpy: Sequence[float] = NodeSettings.camera_rpy,
) -> LampResult:
    """Read the lamps of an image sequence; return their IDs and the last pose, or the reason for none.

    Args:
        images: sequence of images, each of shape (h, w) or (h, w, 3) BGR; an ID takes about a second of them.
        camera: a `Camera`, or the path of its calibration.
        lamps: beacons file, or x, y, z [m] by ID; without them only IDs are read.
        rate: images per second; 60 with a global shutter.
        light: shutter and exposure, as `ReceiverSettings` of the node; a global shutter by default.
        camera_xyz: position of the camera in the robot's frame [m].
        camera_rpy: fixed-axis roll, pitch, yaw of its optical frame there [rad]; by default it looks up.

    Raises:
        InputError, VlcBeaconError, SettingsError: an argument that cannot be used.
    """
    camera, light = as_camera(camera), light or ReceiverSettings()
    if not rate > 0.0:
        raise InputError(f'rate is {rate}; give the images per second')
    check_settings(light)
    mount = CameraMount(as_triple('camera_xyz', camera_xyz), as_triple('camera_rpy', camera_rpy))
    known = _beacons(lamps)
    authorizer = authorizer_from_settings(NodeSettings(), AuthorizationSettings(), known)  # rejects all commands
    receiver, output, found, seen = BeaconReceiver(known, mount, authorizer, light), None, None, {}
    prepare('vlc_beacon')
    for number, image in enumerate(images):
        output = receiver.receive(number / rate, as_image(image, camera), camera)
        if not isinstance(found, BeaconFix) or isinstance(output.result, BeaconFix):
            found = output.result
    if output is None or found is None:
        raise InputError('there are no images; give about a second of them')
    for lamp in output.lamps:
        name = lamp.unknown_id if lamp.beacon is None else lamp.beacon
        if name is not None:
            u, v = lamp.sample.centre.tolist()
            seen[name] = (u, v)
    if isinstance(found, NoBeaconFix):
        return LampResult(reason=found.reason.value, lamps=seen)
    return LampResult(as_pose(found.T_map_base), found.planar_covariance, lamps=seen)


def _beacons(lamps: str | Path | Mapping[int, Sequence[float]] | None) -> list[Beacon]:
    if isinstance(lamps, str | Path):
        return load_beacons(Path(lamps))
    return [Beacon(int(id_), as_triple(f'lamp {id_}', xyz), _RADIUS) for id_, xyz in (lamps or {}).items()]
