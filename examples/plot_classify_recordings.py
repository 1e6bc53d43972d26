"""
Classify your own recordings
============================

From arrays to a trained classifier: make a store, train, evaluate on recordings that were not trained on, and classify
a new one. The recordings are *simulated* here; yours are arrays of samples at some rate, in some unit.
"""

from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt
import numpy as np

import tactogram
from tactogram.datasets import Recording, create_store
from tactogram_simulate import make, tasks

folder = Path(mkdtemp())

# %%
# Six strokes over each of nine surfaces, as arrays of shape (axis, time): what a sensor's log would give you.
recordings = [make(task) for task in tasks("stroking9", seed=1, per_class=6, seconds=2)]
arrays = [np.asarray(recording.stream("acceleration")) for recording in recordings]
names = [recording.material for recording in recordings]
rate = recordings[0].stream("acceleration").rate
print(len(arrays), arrays[0].shape, f"{rate:g} Hz")

# %%
# A recording is one or more signals with a rate and a unit, and whatever is known about them. A store keeps them.
store = create_store(
    folder / "store",
    (
        Recording(
            streams={"acceleration": tactogram.Signal(samples, rate, "m/s^2", ("x", "y", "z"))},
            material=name,
            simulated=True,
        )
        for samples, name in zip(arrays[:-9], names[:-9], strict=True)
    ),
    name="my surfaces",
    licence="mine",
    simulated=True,
)
store[0].stream("acceleration").plot()

# %%
# The published network in a short training: a fifth of the recordings is kept for the test.
run = tactogram.train("stroke_cnn", folder / "store", changes={"config.steps": 100}, out=folder / "run")
report = tactogram.evaluate(run.folder)
print(f"{report['recording_accuracy']:.0%} of the test recordings are classified correctly")

# %%
# A recording that is in no store: its material, or that it is none of these.
answer = tactogram.classify(run.folder, tactogram.Signal(arrays[-1], rate, "m/s^2", ("x", "y", "z")))
print(f"true: {names[-1]}; answer: {answer['material']}")
plt.show()
