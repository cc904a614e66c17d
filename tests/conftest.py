"""Makes benchmarks, the light channel of the beacon's tests and the motor controller of the bridge's importable."""

import importlib
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT / 'src' / name / 'test') for name in ('vlc_beacon', 'motor_bridge')]
sys.path.append(str(ROOT / 'benchmarks'))


@pytest.fixture(scope='module')
def bench(request: pytest.FixtureRequest) -> ModuleType:
    """The benchmark that the module of a test names as its BENCHMARK."""
    return importlib.import_module(request.module.BENCHMARK)


@pytest.fixture(scope='session')
def firmware(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the lamp's firmware and its simulator."""
    return built('led_beacon', tmp_path_factory)


@pytest.fixture(scope='session')
def motor_firmware(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the motor controller's firmware and its simulator."""
    return built('motor_controller', tmp_path_factory)


def built(sketch: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build a firmware, or skip the test where its tools are missing."""
    from simulated_chip import build_firmware, missing_tools  # noqa: PLC0415

    missing = missing_tools()
    if missing and os.environ.get('CI') != 'true':
        packages = 'gcc gcc-avr avr-libc libc6-dev libsimavr-dev make'
        pytest.skip(f'the firmware needs {", ".join(missing)}: apt-get install {packages}')
    folder = tmp_path_factory.mktemp(sketch)
    build_firmware(sketch, folder)
    return folder


@pytest.fixture
def eeprom(tmp_path: Path) -> Path:
    """What a simulated lamp keeps; blank at first."""
    return tmp_path / 'eeprom.bin'


@pytest.fixture
def power_up(firmware: Path, eeprom: Path) -> Iterator[Callable[[], object]]:
    """Powers a simulated lamp up; the one before, which has the same EEPROM, is off then."""
    from simulated_lamp import SimulatedLamp  # noqa: PLC0415

    with ExitStack() as lamps:

        def start() -> SimulatedLamp:
            lamps.close()
            return lamps.enter_context(SimulatedLamp(firmware, eeprom))

        yield start


@pytest.fixture
def lamp(power_up: Callable[[], object]) -> object:
    """A new simulated lamp."""
    return power_up()
