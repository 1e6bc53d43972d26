"""Files as a laboratory has them: tables of two loggers, a matrix, a film and a broken table."""

import numpy as np
from scipy.io import savemat

from tactogram.signal import Signal

T = np.arange(400) / 500


WAVES = np.stack([np.sin(2 * np.pi * 60 * T + phase) for phase in range(3)])


def write(path, heading, rows, separator=","):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([heading, *(separator.join(row) for row in rows)]))


def lab(folder):
    """Write what a laboratory has: tables of two loggers, a matrix, a film and a broken table."""
    for take, material in enumerate(("cork", "felt", "felt")):
        stamps = T + np.random.default_rng(take).normal(0, 1e-4, len(T))
        rows = [
            [f"{t:.5f}", *(f"{v:.5f}" for v in x)] for t, x in zip(stamps, WAVES.T * (1 + take), strict=True)
        ]
        write(folder / material / f"take_{take}.csv", "Elapsed Time,X-Axis (g),Y-Axis (g),Z-Axis (g)", rows)
    clock = [f"23:59:{59 + t:06.3f}" if t < 1 else f"00:00:{t - 1:06.3f}" for t in T + 0.5]
    rows = [
        [stamp, *(f"{v:.5f}".replace(".", ",") for v in x)]
        for stamp, x in zip(clock, WAVES[:2].T, strict=True)
    ]
    write(folder / "Kork ä" / "Messung.csv", "Uhrzeit;Kanal 1;Kraft", rows, ";")
    savemat(folder / "cork" / "matrix.mat", {"data": np.column_stack([T, *WAVES])})
    rows = [["0", "1", "2", "3"], ["0.1", "one", "2", "3"]]
    write(folder / "felt" / "broken.csv", "Elapsed Time,X-Axis (g),Y-Axis (g),Z-Axis (g)", rows)
    (folder / "cork" / "film.mp4").write_bytes(b"film")
    return folder


def labelled(path):
    """Write a table of two materials."""
    rows = [[f"{0.002 * k:.3f}", f"{k % 7}", "cork" if k < 300 else "felt"] for k in range(500)]
    write(path, "t [s],x [g],surface", rows)


def tone(hz, *, rate=1000.0, seconds=1.0, level=1.0):
    """Return a tone on top of gravity."""
    t = np.arange(int(rate * seconds)) / rate
    return Signal(level * np.sin(2 * np.pi * hz * t) + 9.81, rate, "m/s^2")
