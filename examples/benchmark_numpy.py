"""A model for the benchmark in plain NumPy, which knows nothing of tactogram but its files.

    tactogram benchmark questions strokes-name-speed --out questions
    python examples/benchmark_numpy.py questions answers
    tactogram benchmark score strokes-name-speed answers

It describes a signal by its level in bands. A material is named by regularised linear discriminants, is unknown where
the nearest material's mean is far, and is generated as noise with the material's mean spectrum.
"""

import json
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np

BANDS, SHRINKAGE, KEPT = 24, 0.1, 0.95
SEEDS = 3


def bands(samples, rate):
    """Return the level in logarithmic bands from 20 Hz, dB, axis by axis: float64, shape (axis * band,)."""
    power = np.abs(np.fft.rfft(samples * np.hanning(samples.shape[-1]), axis=-1)) ** 2 / samples.shape[-1]
    frequency = np.fft.rfftfreq(samples.shape[-1], 1 / rate)
    edges = np.geomspace(20, min(1000, rate / 2), BANDS + 1)
    places = np.searchsorted(frequency, edges)
    sums = [power[:, low : max(high, low + 1)].mean(-1) for low, high in pairwise(places)]
    return 10 * np.log10(np.maximum(np.array(sums).T, 1e-12)).ravel()


class Materials:
    """Means of materials and one covariance, shrunk towards the identity."""

    def __init__(self, features, names):
        self.centre, self.scale = features.mean(0), features.std(0) + 1e-9
        x = self.standard(features)
        self.names = sorted(set(names))
        self.means = np.stack([x[np.array(names) == name].mean(0) for name in self.names])
        within = x - self.means[[self.names.index(name) for name in names]]
        covariance = within.T @ within / len(x)
        self.whiten = np.linalg.inv(
            np.linalg.cholesky((1 - SHRINKAGE) * covariance + SHRINKAGE * np.eye(len(covariance)))
        )

    def standard(self, features):
        """Return features of mean 0 and standard deviation 1 in training."""
        return (features - self.centre) / self.scale

    def distances(self, features):
        """Return squared distances to each material's mean, shape (material,)."""
        return (((self.standard(features) - self.means) @ self.whiten.T) ** 2).sum(-1)


def noise_like(recordings, length, rng):
    """Return noise of the recordings' mean amplitude spectrum, shape (axis, length)."""
    spectra = [
        np.abs(np.fft.rfft(x, length, axis=-1)) / np.sqrt(min(x.shape[-1], length)) for x in recordings
    ]
    amplitude = np.sqrt(np.mean(np.square(spectra), axis=0) * length)
    phases = np.exp(2j * np.pi * rng.random(amplitude.shape))
    return np.fft.irfft(amplitude * phases, length, axis=-1)


def main(questions, answers):
    """Read a folder of questions, and write answers."""
    task = json.loads((questions / "task.json").read_text(encoding="utf-8"))
    what, signal = task["answer"]["what"], task["signal"]
    if what not in ("probabilities", "strangeness", "embedding", "signal") or not task["train"]:
        sys.exit(
            f"{task['task']}: asks for {what}; this example names, refuses, embeds and generates materials"
        )
    train, asked = np.load(questions / "train.npz"), np.load(questions / "questions.npz")
    rate = signal["rate"]
    samples = {example["id"]: train[example["id"]] for example in task["train"]}
    names = [example["material"] for example in task["train"]]
    known = Materials(np.stack([bands(x, rate) for x in samples.values()]), names)
    held = np.load(questions / "validation.npz")
    near = sorted(known.distances(bands(held[e["id"]], rate)).min() for e in task["validation"])
    threshold = near[min(len(near) - 1, int(np.ceil((len(near) + 1) * KEPT)) - 1)] if near else np.inf

    def answer(question, seed):
        given = question["given"]
        if what == "signal":
            if not isinstance(given.get("material"), str) or signal["domain"] != "time":
                sys.exit(f"{task['task']}: this example generates materials over time")
            rng = np.random.default_rng([seed, sum(question["id"].encode())])
            recordings = [samples[e["id"]] for e in task["train"] if e["material"] == given["material"]]
            return noise_like(recordings, int(np.ceil(question["seconds"] * rate)), rng)
        features = bands(asked[given["vibration"]], rate)
        if what == "embedding":
            return known.whiten @ known.standard(features)
        distances = known.distances(features)
        if what == "strangeness":
            return np.array([distances.min(), float(distances.min() > threshold)])
        shares = np.exp(-(distances - distances.min()) / 2)
        return (shares / shares.sum())[[known.names.index(name) for name in task["answer"]["names"]]]

    answers.mkdir(parents=True, exist_ok=True)
    for seed in range(SEEDS if what == "signal" else 1):
        found = {question["id"]: answer(question, seed) for question in task["questions"]}
        np.savez(answers / f"{seed}.npz", **found)
    about = {"model": "numpy_bands", "how": "band levels and linear discriminants, or noise, in NumPy"}
    (answers / "about.json").write_text(json.dumps(about), encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: python benchmark_numpy.py QUESTIONS ANSWERS")
    main(Path(sys.argv[1]), Path(sys.argv[2]))
