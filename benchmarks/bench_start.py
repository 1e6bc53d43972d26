"""`tactogram --help` beside `python -c pass`: whole processes, in turns."""

import subprocess
import sys
import time
from pathlib import Path
from statistics import median

COMMANDS = {
    "python -c pass": [sys.executable, "-c", "pass"],
    "tactogram --help": [str(Path(sys.executable).with_name("tactogram")), "--help"],
    "tactogram models": [str(Path(sys.executable).with_name("tactogram")), "models"],
}


def run():
    times = {name: [] for name in COMMANDS}
    for _ in range(12):
        for name, command in COMMANDS.items():
            start = time.perf_counter()
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            times[name].append(time.perf_counter() - start)
    base = median(times["python -c pass"][2:])
    return [
        {"command": name, "seconds": median(t[2:]), "times python -c pass": median(t[2:]) / base}
        for name, t in times.items()
    ]
