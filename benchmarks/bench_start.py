"""`tactogram --help` beside `python -c pass`: whole processes, in turns."""

import subprocess
import sys
import time
from pathlib import Path
from statistics import median

from benchmarks.timing import seconds_of

COMMANDS = {
    "python -c pass": [sys.executable, "-c", "pass"],
    "tactogram --help": [str(Path(sys.executable).with_name("tactogram")), "--help"],
    "tactogram models": [str(Path(sys.executable).with_name("tactogram")), "models"],
}


def run():
    times = {name: [] for name in COMMANDS}
    for _ in range(12):
        for name, command in COMMANDS.items():
            times[name].append(
                seconds_of(
                    lambda: subprocess.run(command, check=True, stdout=subprocess.DEVNULL),  # noqa: B023
                    time.perf_counter,
                )
            )
    base = median(times["python -c pass"][2:])
    return [
        {"command": name, "seconds": median(t[2:]), "times python -c pass": median(t[2:]) / base}
        for name, t in times.items()
    ]
