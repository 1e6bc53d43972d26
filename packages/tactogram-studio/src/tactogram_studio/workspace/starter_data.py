"""Example data for an empty workspace: autoregressive textures of simulated surfaces, made on the first start."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import threading
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from tactogram.main_script import start_worker

State = Literal["absent", "making", "ready", "failed"]
PER_CLASS, SECONDS, SEED = 2, 1.5, 0
SPEEDS_MM_S = (50.0, 100.0, 200.0)
"""Speeds of the strokes: several, so that the textures follow the speed of a hand."""


@dataclass
class StarterData:
    """The run ``voices`` and the store ``surfaces`` in a folder, made by a separate process."""

    folder: Path
    line: str = ""
    """Progress of the process, or the reason why it failed."""
    _lock: threading.Lock = field(default_factory=threading.Lock, repr=False)
    _making: bool = False

    @property
    def run(self) -> Path:
        """Run of autoregressive textures."""
        return self.folder / "voices"

    @property
    def store(self) -> Path:
        """Store of simulated surfaces."""
        return self.folder / "surfaces"

    @property
    def state(self) -> State:
        """Progress so far."""
        if (self.run / "model.json").is_file():
            return "ready"
        if self._making:
            return "making"
        return "failed" if self.line else "absent"

    def make(self) -> None:
        """Start making the data in the background, unless it is ready or being made."""
        with self._lock:
            if self._making or self.state == "ready":
                return
            self._making, self.line = True, "starting"
            threading.Thread(target=self._make, name="starter data", daemon=True).start()

    def _make(self) -> None:
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            for folder in (self.store, self.run):  # left unfinished by an earlier process
                shutil.rmtree(folder, ignore_errors=True)
            self._follow([sys.executable, "-m", __name__, str(self.store), str(self.run)])
        except OSError as error:
            self.line = f"the example surfaces could not be made: {error}"
        finally:
            self._making = False

    def _follow(self, command: list[str]) -> None:
        """Run a command with its last line of output in ``line``."""
        environment = {**os.environ, "OMP_NUM_THREADS": "1"}
        with subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment
        ) as process:
            for line in process.stdout or ():
                self.line = line.strip()
        self.line = "" if not process.returncode else f"the example surfaces could not be made: {self.line}"


def make(store: Path, run: Path) -> None:
    """Simulate the surfaces and fit their textures, with progress on stdout."""
    from tactogram.workflows import train
    from tactogram_simulate import simulate_to_store

    sys.stdout.write("simulating nine surfaces\n")
    sys.stdout.flush()
    # One process: starting more takes longer than they save.
    simulate_to_store(
        "stroking9",
        store,
        seed=SEED,
        per_class=PER_CLASS,
        seconds=SECONDS,
        speeds_mm_s=SPEEDS_MM_S,
        workers=1,
    )
    sys.stdout.write("fitting their textures\n")
    sys.stdout.flush()
    train("texture_var", store, split="all", out=run)


if __name__ == "__main__":
    start_worker(parent_id=os.getppid())  # a later server would make them anew in the same folders
    make(Path(sys.argv[1]), Path(sys.argv[2]))
