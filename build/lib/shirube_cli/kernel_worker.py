"""A process that compiles kernel sets.

It reads names of sets from standard input, one a line, and answers on standard output: ``kernel`` for each function
compiled, ``done`` for each set. Started by ``kernel_compiler``; what numba needs for all sets it compiles once.
"""

import gc
import os
import sys
from importlib import import_module
from typing import Any, TextIO

from numba.core import event, lowering

from shirube_cli.kernel_registry import KERNEL_SETS


def main() -> int:
    """Compile what is asked for until the input ends; return 0, or 1 if the disk refused."""
    # A compiler makes millions of objects that stay; searching them for garbage again and again is wasted time.
    gc.set_threshold(200_000, 20, 100)
    _omit_c_wrappers()
    # The kernels' own output must not be taken for answers.
    with os.fdopen(os.dup(sys.stdout.fileno()), 'w', encoding='ascii', buffering=1) as answers:
        sys.stdout = sys.stderr
        event.register('numba:compile', _KernelListener(answers))
        sets = {one.name: one for one in KERNEL_SETS}
        for line in sys.stdin:
            chosen = sets[line.strip()]
            try:
                eval(chosen.call, vars(import_module(chosen.module)))  # noqa: S307 a call of KERNEL_SETS
            except OSError as error:
                print(f'shirube: cannot write {error.filename}: {error.strerror}', file=sys.stderr)
                return 1
            print('done', file=answers)
    return 0


class _KernelListener(event.Listener):
    """Reports each function of the suite once, when it has been compiled."""

    def __init__(self, answers: TextIO) -> None:
        self._answers = answers
        self._seen: set[str] = set()
        self._packages = {one.module.partition('.')[0] for one in KERNEL_SETS} | {'scene_simulator'}

    def on_start(self, event: Any) -> None:
        """Do nothing: only what has ended counts."""

    def on_end(self, event: Any) -> None:
        """Report the function of a ``numba:compile`` event."""
        function = event.data['dispatcher'].py_func
        name = f'{function.__module__}.{function.__qualname__}'
        if name not in self._seen and name.partition('.')[0] in self._packages:
            self._seen.add(name)
            print('kernel', file=self._answers)


def _omit_c_wrappers() -> None:
    """Leave out the entry for callers in C that numba adds to each function: no kernel is called so.

    It takes an eighth of the time of compilation. Kernels and their speed are the same without it.
    """
    if hasattr(lowering.Lower, 'create_cfunc_wrapper'):
        lowering.Lower.create_cfunc_wrapper = lambda _: None
