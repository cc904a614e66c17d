"""The numba kernels of all packages: which call compiles which, how many they are, and which come first."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class KernelSet:
    """Kernels that are compiled together.

    Attributes:
        name: unique name, which is also that of the file that marks the set as compiled.
        module: the module to import, of the package whose executables need the set.
        call: the call of one of its functions that compiles all kernels of the set.
        kernels: how many functions are compiled that no earlier set of the package compiles.
        demo: whether ``shirube demo`` needs the set.
    """

    name: str
    module: str
    call: str
    kernels: int
    demo: bool = True

    @property
    def package(self) -> str:
        """The package whose executables need the set."""
        return self.module.partition('.')[0]


_LIGHT = 'vlc_beacon.core.receiver.compile_kernels'
KERNEL_SETS = (
    KernelSet('floor_localizer', 'floor_localizer.localization.localizer_from_map_file', 'compile_kernels()', 134),
    KernelSet('stereo_landmark', 'stereo_landmark.core.compile_kernels', 'compile_kernels()', 122),
    KernelSet('vlc_beacon_rolling', _LIGHT, "compile_kernels(ReceiverSettings('rolling'))", 16),
    KernelSet('shirube_bringup', 'shirube_bringup.building', 'compile_kernels()', 28),
    KernelSet('reward_planner', 'reward_planner.core.compile_kernels', 'compile_default_kernels()', 32),
    KernelSet('collision_monitor', 'reward_planner.core.safety.compile_kernels', 'compile_kernels()', 19, demo=False),
    KernelSet('vlc_beacon_global', _LIGHT, "compile_kernels(ReceiverSettings('global'))", 2, demo=False),
)
"""In the order in which they are compiled: those of the demo first, of these the longest first."""
_DEPENDENCY = re.compile(r'<exec_depend>(\w+)</exec_depend>')
DEMO_SETS = tuple(one for one in KERNEL_SETS if one.demo)


def sets_of_package(root: Path, package: str) -> tuple[KernelSet, ...]:
    """Return the kernel sets of a package and of the packages that it depends on."""
    needed = {package}
    waiting = [package]
    while waiting:
        xml = root / 'src' / waiting.pop() / 'package.xml'
        if xml.is_file():
            new = set(_DEPENDENCY.findall(xml.read_text())) - needed
            needed |= new
            waiting.extend(new)
    return sets_of_packages(needed)


def sets_of_packages(packages: Iterable[str]) -> tuple[KernelSet, ...]:
    """Return the kernel sets of some packages, in the order in which they are compiled."""
    names = set(packages)
    return tuple(one for one in KERNEL_SETS if one.package in names)
