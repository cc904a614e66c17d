"""Settings of the emulated controller and robot."""

from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class EmulatorSettings:
    """True dimensions of the robot, its motors, encoders and slip."""

    firmware: str = setting(
        'ros_arduino_bridge',
        'emulated firmware; motor_controller adds checksums and a shorter auto-stop to the other',
        choices=('ros_arduino_bridge', 'motor_controller'),
    )
    baud: int = setting(57600, 'baud rate in the reply to b', 'baud', (1200, 4_000_000))
    wheel_radius: float = setting(0.033, 'true wheel radius', 'm', (0.005, 1.0))
    wheel_separation: float = setting(0.2, 'true distance between the centres of the wheels', 'm', (0.02, 5.0))
    ticks_per_revolution: int = setting(1440, 'encoder counts per revolution of a wheel', limits=(4, 1_000_000))
    wheel_speed_max: float = setting(25.0, 'speed of a wheel at full voltage', 'rad/s', (0.5, 500.0))
    motor_time_constant: float = setting(0.06, 'time in which a wheel reaches 63 % of its speed', 's', (0.001, 5.0))
    motor_dead_band: int = setting(12, 'greatest PWM at which a motor does not turn, of 255', limits=(0, 200))
    slip: float = setting(0.0, 'mean slip of a wheel, fraction of its distance', limits=(-0.5, 0.5))
    slip_sigma: float = setting(0.005, 'standard deviation of the slip after one metre, fraction', limits=(0.0, 0.5))
    encoder_noise: float = setting(0.3, 'standard deviation of a count', 'ticks', (0.0, 100.0))
    pid_frame: float = setting(
        0.0363,
        'true period of the speed control, which assumes 33 ms: so speeds are 9 % below the commands',
        's',
        (0.005, 0.5),
    )
    auto_stop: float = setting(2.0, 'time after the last command at which the motors stop', 's', (0.05, 60.0))
    boot_time: float = setting(1.5, 'time after a reset without reception', 's', (0.0, 30.0))
