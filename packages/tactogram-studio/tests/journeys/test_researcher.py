"""A researcher: from a folder of a logger's tables to a classifier, a mix, and the drive of an actuator."""

import numpy as np
from scipy.signal import lfilter

from tactogram.datasets import open_store
from tactogram.signal.io import read_signal

MATERIALS = {"cork": 0.9, "felt": 0.3, "tile": -0.6}
HEADING = "Elapsed Time (s);X-Axis (g);Y-Axis (g);Z-Axis (g)"


def log(file, pole, seed):
    """Write what a logger with semicolons, decimal commas and jittered stamps writes."""
    rng = np.random.default_rng(seed)
    times = np.arange(4000) / 1000 + rng.normal(0, 2e-5, 4000)
    g = 0.1 * lfilter([1], [1, -pole], rng.standard_normal((3, 4000)))
    rows = (";".join(f"{value:.6f}" for value in row).replace(".", ",") for row in np.vstack([times, g]).T)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("\n".join(["Logger 2.1", "", HEADING, *rows]))


def test_own_tables_become_a_classifier_a_mix_and_a_drive(tactogram, tmp_path, step):
    for name, pole in MATERIALS.items():
        for number in range(10):
            log(tmp_path / "lab" / name / f"{number}.csv", pole, seed=len(name) * 100 + number)
    (tmp_path / "lab/felt/broken.csv").write_text(f"{HEADING}\n0,1;a;b;c\n")
    with step("preview"):
        said = tactogram("data import folder lab --preview", status=1)
    assert "broken.csv" in said
    with step("import"):
        tactogram("data import folder lab --out store --skip-bad")
    store = open_store(tmp_path / "store")
    assert len(store) == 30
    assert store[0].stream("acceleration").rate == 1000.0
    with step("train a classifier"):
        tactogram("train stroke_cnn --data store --out runs/names")
    with step("evaluate it"):
        said = tactogram("evaluate runs/names")
    with step("fit a generator, mix, classify the mix"):
        tactogram("train texture_var --data store --out runs/textures")
        tactogram("generate runs/textures --mix cork=0.5,felt=0.5 --seconds 3 --out mix.wav")
        tactogram("classify runs/names mix.wav")
    with step("a drive for a voice coil"):
        tactogram("render mix.wav --display voice-coil --level sensation --out drive.wav")
    drive = read_signal(tmp_path / "drive.wav")
    assert 2.9 < drive.seconds < 3.2
    assert drive.unit == "V"
    assert 0 < np.abs(drive.samples).max() <= 5  # its limit
