"""
A model of your own
===================

A classifier of your own takes part beside the built-in ones: the same training, data, splits and figures. Here it is
scikit-learn's logistic regression on levels in frequency bands. The recordings are *simulated*.
"""

from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt

import tactogram
from tactogram_simulate import simulate_to_store

folder = Path(mkdtemp())
simulate_to_store("stroking9", folder / "store", per_class=8, seconds=2, seed=1, workers=1)

# %%
# A model is a folder with three files: facts, a recipe, and the code.
model = folder / "models" / "band_regression"
(model / "recipes").mkdir(parents=True)
(model / "model.toml").write_text("""
title = "Logistic regression on band levels"
authors = ["Me"]
year = 2026
task = "classification"
needs = ["vibration"]
gives = "probabilities"
""")
(model / "recipes" / "quick.toml").write_text("""
model = "band_regression"
[prepare]
band = [20.0, 400.0]
""")

# %%
# The code: what to keep, what to do in a training step, and what to answer. Recordings arrive filtered and resampled as
# the recipe says. A training is one step, on all of them, unless the model says otherwise.
(model / "__init__.py").write_text("""
import numpy as np
from sklearn.linear_model import LogisticRegression

from tactogram.model import Model, ModelConfig


class Config(ModelConfig):
    bands: int = 16
    strength: float = 1.0


class BandRegression(Model):
    saved = ("materials", "weights", "biases")
    weights, biases = np.zeros((0, 0)), np.zeros(0)

    def features(self, signal):
        power = (np.abs(np.fft.rfft(signal.samples)) ** 2).mean(0)
        frequencies = np.fft.rfftfreq(len(signal), 1 / signal.rate)
        edges = np.geomspace(20, 400, self.config.bands + 1)
        return [np.log(power[(frequencies >= a) & (frequencies < b)].mean()) for a, b in zip(edges, edges[1:])]

    def step(self, stage, batch):
        fitted = LogisticRegression(C=self.config.strength, solver="newton-cholesky").fit(
            [self.features(example.signal) for example in batch],
            [self.materials.index(example.material) for example in batch],
        )
        self.weights, self.biases = fitted.coef_, fitted.intercept_
        return {"recordings": float(len(batch))}

    def probabilities(self, signal):
        scores = self.weights @ self.features(signal) + self.biases
        shares = np.exp(scores - scores.max())
        return shares / shares.sum()


build = BandRegression
""")

# %%
# It is trained as any other model is. The run remembers where the model's folder is.
models = [folder / "models"]
mine = tactogram.train("band_regression", folder / "store", out=folder / "mine", model_folders=models)
theirs = tactogram.train("stroke_cnn", folder / "store", changes={"config.steps": 100}, out=folder / "theirs")

# %%
# Both are evaluated on the same recordings, which neither was trained on.
figures = {run.folder.name: tactogram.evaluate(run.folder) for run in (mine, theirs)}
shares = {"logistic regression": figures["mine"], "stroke_cnn, 100 steps": figures["theirs"]}
plt.figure(figsize=(6, 2))
plt.barh(list(shares), [100 * found["recording_accuracy"] for found in shares.values()])
plt.xlabel("test recordings classified correctly, %")
plt.tight_layout()

# %%
# Its settings are checked and changed like those of a built-in model, and every verb takes its runs.
more = tactogram.train(
    "band_regression",
    folder / "store",
    changes={"config.bands": 24},
    out=folder / "more",
    model_folders=models,
)
signal = tactogram.open_store(folder / "store")[0].stream("acceleration")
print(tactogram.classify(more.folder, signal)["material"])
plt.show()
