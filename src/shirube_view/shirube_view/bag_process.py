"""Records a bag in a process of its own, so that a full disk or a slow codec never disturbs the page."""

import signal
import subprocess
import sys
import time
from pathlib import Path


class BagProcess:
    """Starts and ends the recorder."""

    def __init__(self, folder: Path) -> None:
        """Set the folder of the bags."""
        self._folder, self._path = folder, folder
        self._process: subprocess.Popen[bytes] | None = None

    @property
    def is_running(self) -> bool:
        """Whether a bag is being recorded."""
        return self._process is not None and self._process.poll() is None

    def toggle(self) -> str:
        """Start or end a recording and return in words what was done."""
        if self.is_running:
            self.close()
            return f'recorded to {self._path}'
        self._path = self._folder / time.strftime('drive_%Y%m%d_%H%M%S')
        command = [sys.executable, '-m', 'shirube_bags.commands.record', '-o', str(self._path)]
        self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, start_new_session=True)
        return f'recording to {self._path}'

    def close(self) -> None:
        """End the recording; the bag is completed in the background."""
        if self._process is not None and self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
