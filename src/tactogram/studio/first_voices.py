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
PER_CLASS, SECONDS, SEED = 3, 2.0, 0


@dataclass
class FirstVoices:
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
            simulate = ["data", "simulate", "stroking9", "--out", str(self.store), "--seed", str(SEED)]
            self._call(
                "simulating nine surfaces",
                [*simulate, "--per-class", str(PER_CLASS), "--seconds", str(SECONDS)],
            )
            learn = [
                "train",
                "ar_texture",
                "--data",
                str(self.store),
                "--split",
                "all",
                "--out",
                str(self.run),
            ]
            self._call("learning their textures", learn)
            self.line = ""
        except (OSError, subprocess.SubprocessError) as error:
            self.line = f"the first surfaces could not be made: {error}"
        finally:
            self._making = False

    def _call(self, line: str, arguments: list[str]) -> None:
        self.line = line
        done = subprocess.run(
            [sys.executable, "-m", "tactogram.cli", *arguments],
            check=False,
            capture_output=True,
            text=True,
            env={**os.environ, "OMP_NUM_THREADS": "1"},
        )
        if done.returncode:
            said = done.stderr.strip().splitlines()
            raise subprocess.SubprocessError(said[-1] if said else f"exit {done.returncode}")
