"""Files read in parallel, and what is said of many of them in one line."""

import signal
import subprocess
import sys

import numpy as np
import psutil
import pytest
from PIL import Image as Pillow

from tactogram.datasets.reading import by_kind, in_one_line


def test_what_is_said_of_many_files_is_one_line():
    said = [(f"cork/{n}.csv", f"cork/{n}.csv: row {n}: expected a number, got 'x{n}'") for n in range(12)]
    [kind] = by_kind(said)
    assert (kind["count"], kind["files"]) == (12, ["cork/0.csv", "cork/1.csv", "cork/2.csv"])
    assert in_one_line(kind) == (
        "12 files: row 0: expected a number, got 'x0' (cork/0.csv, cork/1.csv, cork/2.csv, …)"
    )
    assert in_one_line(by_kind(said[:1])[0]) == said[0][1]


def write_material(folder, number, *, recordings=3, frames=20, **changes):
    """Write ``matNN.npz`` as BioTac_slide has it."""
    rng = np.random.default_rng(number)
    rows = recordings * frames
    arrays = {
        "pac": rng.integers(0, 900, (rows, 22), dtype=np.int16),
        "tdc": rng.integers(0, 9, rows, dtype=np.int16),
        "tac": rng.integers(0, 200, rows, dtype=np.int16),
        "pdc": rng.integers(0, 200, rows, dtype=np.int16),
        "electrodes": rng.integers(0, 99, (rows, 19), dtype=np.int16),
        "lengths": np.full(recordings, frames, np.int32),
        "recording": np.arange(1, recordings + 1, dtype=np.int16),
        "pac_rate_hz": np.int32(2200),
        "frame_rate_hz": np.int32(100),
    }
    folder.mkdir(exist_ok=True)
    np.savez(folder / f"mat{number:02d}.npz", **(arrays | changes))
    return arrays


@pytest.fixture
def source(tmp_path):
    folder = tmp_path / "source"
    for number in range(1, 5):
        write_material(folder, number)
    (folder / "materials.csv").write_text(
        "material_id,name,code\n" + "".join(f"{n},Material {n},M{n}\n" for n in range(1, 5))
    )
    (folder / "images").mkdir()
    Pillow.new("RGB", (6, 4), (200, 100, 50)).save(folder / "images" / "mat02.jpg")
    return folder


IMPORT = """
import sys
from pathlib import Path
from tactogram.datasets.importing import import_dataset

if __name__ == "__main__":
    import_dataset("biotac_slide", Path(sys.argv[1]), Path(sys.argv[2]), workers=2,
                   progress=lambda done, total: print(done, flush=True))
"""


def test_a_killed_import_leaves_no_process_behind(source, tmp_path):
    script = source / "import.py"
    script.write_text(IMPORT)
    process = subprocess.Popen(
        [sys.executable, script, source, tmp_path / "s"], stdout=subprocess.PIPE, text=True
    )
    process.stdout.readline()
    children = psutil.Process(process.pid).children(recursive=True)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    _, alive = psutil.wait_procs(children, timeout=60)
    assert len(children) >= 2
    assert alive == []
