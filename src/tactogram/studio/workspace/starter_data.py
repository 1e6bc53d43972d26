"""Something to play with at once: autoregressive textures of simulated surfaces, made on the first start."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import threading
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

State = Literal["absent", "making", "there", "failed"]
PER_CLASS, SECONDS, SEED = 2, 1.5, 0
SPEEDS_MM_S = (50.0, 100.0, 200.0)
"""Of the strokes: more than one, so that what is felt can follow the speed of a hand."""


@dataclass
class StarterData:
    """The run ``voices`` and the store ``surfaces`` in a folder, made by a process of its own.

    Parameters
    ----------
    folder : Path
    """

    folder: Path
    line: str = ""
    """What the process is at, or why it failed."""
    _lock: threading.Lock = field(default_factory=threading.Lock, repr=False)
    _making: bool = False

    @property
    def run(self) -> Path:
        """The run of autoregressive textures."""
        return self.folder / "voices"

    @property
    def store(self) -> Path:
        """The simulated surfaces."""
        return self.folder / "surfaces"

    @property
    def state(self) -> State:
        """How far it is."""
        if (self.run / "model.json").is_file():
            return "there"
        if self._making:
            return "making"
        return "failed" if self.line else "absent"

    def make(self) -> None:
        """Begin to make them in the background, unless they are there or being made."""
        with self._lock:
            if self._making or self.state == "there":
                return
            self._making, self.line = True, "beginning"
            threading.Thread(target=self._make, name="first voices", daemon=True).start()

    def _make(self) -> None:
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            for gone in (self.store, self.run):  # what an earlier process left unfinished
                shutil.rmtree(gone, ignore_errors=True)
            self._follow([sys.executable, "-m", __name__, str(self.store), str(self.run)])
        except OSError as error:
            self.line = f"the first surfaces could not be made: {error}"
        finally:
            self._making = False

    def _follow(self, command: list[str]) -> None:
        """Run a command, and have ``line`` say what it says."""
        environment = {**os.environ, "OMP_NUM_THREADS": "1"}
        with subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment
        ) as process:
            for line in process.stdout or ():
                self.line = line.strip()
        self.line = "" if not process.returncode else f"the first surfaces could not be made: {self.line}"


def make(store: Path, run: Path) -> None:
    """Simulate the surfaces and learn their textures, saying on stdout what is being done."""
    from tactogram.workflows.data.simulate import simulate_to_store
    from tactogram.workflows.training.train import train

    sys.stdout.write("simulating nine surfaces\n")
    sys.stdout.flush()
    # One process: to start more takes longer than they save.
    simulate_to_store(
        "stroking9",
        store,
        seed=SEED,
        per_class=PER_CLASS,
        seconds=SECONDS,
        speeds_mm_s=SPEEDS_MM_S,
        workers=1,
    )
    sys.stdout.write("learning their textures\n")
    sys.stdout.flush()
    train("ar_texture", store, split="all", out=run)


if __name__ == "__main__":
    make(Path(sys.argv[1]), Path(sys.argv[2]))
