"""An author of models: arrays in, arrays out, and a model of her own in the common table."""

import subprocess
import sys
from pathlib import Path

EXAMPLE = Path(__file__).parents[4] / "examples/benchmark_numpy.py"
TASK = "strokes-name-speed"
NOTEBOOK = """
import numpy as np
import tactogram
from tactogram.datasets import Recording, create_store

rng = np.random.default_rng(0)
store = create_store(
    "store",
    [
        Recording(
            streams={"acceleration": tactogram.Signal(scale * rng.standard_normal((3, 2000)), 1000, "m/s^2")},
            material=name,
        )
        for name, scale in {"silk": 1, "grater": 5}.items()
        for _ in range(6)
    ],
    name="mine", licence="mine",
)
X, y, groups = store.to_numpy()
print(X.shape, sorted(set(y.tolist())))
touch = tactogram.pipeline("text-to-touch")("corduroy", speed_mm_s=120, seconds=1)
print(np.asarray(touch).shape, touch.rate, touch.unit)
"""


def test_arrays_in_arrays_out_and_an_own_model_is_ranked(tactogram, tmp_path, step):
    with step("arrays to a store and back, text to an array"):
        done = subprocess.run(
            [sys.executable, "-c", NOTEBOOK], cwd=tmp_path, capture_output=True, text=True, check=False
        )
    assert done.returncode == 0, done.stderr
    assert "(12, 3, 2000) ['grater', 'silk']" in done.stdout
    assert "(1, 2500) 2500.0 m/s^2" in done.stdout
    with step("a task's recordings, as arrays"):
        tactogram(f"benchmark questions {TASK} --out questions")
    with step("answers in plain NumPy"):
        subprocess.run([sys.executable, EXAMPLE, "questions", "answers"], cwd=tmp_path, check=True)
    with step("its figure, and the table"):
        said = tactogram(f"benchmark score {TASK} answers")
        tactogram("benchmark table runs/benchmark/results --out table.md")
    assert "numpy_bands" in said
    assert "numpy_bands" in (tmp_path / "table.md").read_text()
