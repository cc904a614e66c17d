"""The emulated controller and its robot."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class EmulatorSettings:
    """True dimensions of the robot, its motors, its encoders and how its wheels slip."""

    baud: int = setting(
        57600, 'what the controller answers to b', unit='baud', minimum=1200, maximum=4_000_000
    )
    wheel_radius: float = setting(0.033, 'true radius of the wheels', unit='m', minimum=0.005, maximum=1.0)
    wheel_separation: float = setting(
        0.2, 'true distance between the middles of the wheels', unit='m', minimum=0.02, maximum=5.0
    )
    ticks_per_revolution: int = setting(1440, 'of a wheel', minimum=4, maximum=1_000_000)
    wheel_speed_max: float = setting(
        25.0, 'of a wheel at full voltage', unit='rad/s', minimum=0.5, maximum=500.0
    )
    motor_time_constant: float = setting(
        0.06, 'in which a wheel gains 63 % of its speed', unit='s', minimum=0.001, maximum=5.0
    )
    motor_dead_band: int = setting(
        12, 'a motor stands still with so much PWM or less, of 255', minimum=0, maximum=200
    )
    slip: float = setting(0.0, 'share of its way that a wheel slips, on average', minimum=-0.5, maximum=0.5)
    slip_sigma: float = setting(
        0.005,
        'noise of the slip: its standard deviation after one metre, as a share',
        minimum=0.0,
        maximum=0.5,
    )
    encoder_noise: float = setting(
        0.3, 'standard deviation of a read count', unit='ticks', minimum=0.0, maximum=100.0
    )
    pid_frame: float = setting(
        0.0363,
        'true time between two rounds of the speed control, which counts 33 ms: so it holds 9 % less than it is told',
        unit='s',
        minimum=0.005,
        maximum=0.5,
    )
    auto_stop: float = setting(
        2.0, 'the motors stop so long after the last command', unit='s', minimum=0.05, maximum=60.0
    )
    boot_time: float = setting(
        1.5, 'the controller is deaf for so long after a reset', unit='s', minimum=0.0, maximum=30.0
    )
