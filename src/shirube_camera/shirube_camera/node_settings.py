"""Parameters of the node."""

from dataclasses import dataclass

from shirube_core.settings import setting, tunable


@tunable('exposure_time', 'gain', 'focus')
@dataclass(frozen=True)
class CameraNodeSettings:
    """Source, controls of the camera, and output."""

    device: str = setting(
        '/dev/video0',
        'camera: number, /dev/videoN, /dev/v4l/by-id/... (stays the same camera); or a video, or a folder of images',
    )
    width: int = setting(0, "width of the images; 0: the driver's", unit='px', minimum=0, maximum=16384)
    height: int = setting(0, "height of the images; 0: the driver's", unit='px', minimum=0, maximum=16384)
    rate: float = setting(
        0.0, "images per second; 0: the source's, 30 for a folder", minimum=0.0, maximum=1e3
    )
    pixel_format: str = setting(
        '', "such as YUYV, GREY (exact), MJPG (more images per second); empty: the driver's"
    )
    exposure_time: float = setting(
        0.0, 'in steps of 0.1 ms; 0: automatic', unit='s', minimum=0.0, maximum=1.0
    )
    gain: float = setting(-1.0, "gain in the driver's unit; -1: unchanged", minimum=-1.0, maximum=1e5)
    focus: float = setting(-1.0, "fixed focus in the driver's unit; -1: unchanged", minimum=-1.0, maximum=1e5)
    loop: bool = setting(False, 'whether a video or folder starts again at its end')
    split: str = setting(
        'none',
        'left_right: halves of the images of a stereo camera are published in left/ and right/',
        choices=('none', 'left_right'),
    )
    encoding: str = setting('mono8', 'of image_raw; all localizers use grey', choices=('mono8', 'bgr8'))
    calibration_file: str = setting(
        '', 'YAML of camera_calibration; with split, the folder with left.yaml and right.yaml; empty: none'
    )
    camera_frame: str = setting('camera_optical_frame', 'frame_id of the messages')
    latency: float = setting(
        0.03, 'from exposure to arrival, if the driver gives no stamp', unit='s', minimum=0.0, maximum=1.0
    )
