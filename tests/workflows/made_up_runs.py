"""Runs that draw, hum and judge as told, in the place of trained ones."""

from types import SimpleNamespace

import numpy as np

from tactogram.model import ImageKind, Model, SignalKind, check_condition
from tactogram.signal import Image, Signal
from tactogram.workflows.training.loaded_run import LoadedRun

WORDS = ("rough", "sleek", "sticky")


class Drawing(Model):
    """An image of as many rows as words, each as bright as its score."""

    step = rated_means = None

    def __init__(self, kind, means):
        super().__init__(None, kind)
        self.rated_means, self.asked = means, []

    def generate(self, condition, *, seconds=None, seed):
        check_condition(condition, needs=("words",))
        self.asked.append(condition)
        rows = np.array([condition["words"][word] for word in self.kind.words]) * 200
        noise = np.random.default_rng(seed).integers(0, 50, (3, 4, 3))
        return Image((rows[:, None, None] + noise).astype(np.uint8))


class Humming(Drawing):
    """A signal whose samples are its scores, and noise."""

    def generate(self, condition, *, seconds=None, seed):
        check_condition(condition, needs=("words",), takes=("vibration",))
        self.asked.append(condition)
        rows = np.array([condition["words"][word] for word in self.kind.words])
        return Signal(
            (rows + np.random.default_rng(seed).random(3)).astype(np.float32), 100.0, "1", ("drive",)
        )

    def selection_for(self, condition, seed):
        return {"cluster": 2, "plate": "plate01"}


class Judge(Model):
    """Says 6 of 7 of everything."""

    step = None

    def predict(self, given):
        return dict.fromkeys(WORDS, 6.0)


def run(name, model, kind, gives, takes=(), needs=("words",), simulated=True):
    return LoadedRun(
        SimpleNamespace(name=name, folder=f"runs/{name}", data={"run_id": f"{name}-id"}),
        SimpleNamespace(
            instead=(),
            name=f"{name}_model",
            task="prediction" if gives == "scores" else "generation",
            gives=gives,
            needs=needs,
            conditions=(*needs, *takes),
        ),
        SimpleNamespace(
            prepare=SimpleNamespace(model_copy=lambda update: SimpleNamespace(apply=lambda x: x))
        ),
        kind,
        model,
    )


def pictures(items=None):
    items = {"image1": [0.0, 0.5, 1.0], "image2": [0.5, 0.5, 0.0]} if items is None else items
    kind = ImageKind(WORDS, (0.0, 1.0), tuple(items), simulated=True)
    return run("sight", Drawing(kind, {k: np.array(v) for k, v in items.items()}), kind, "image")


def vibrations(words=WORDS):
    kind = SignalKind(100.0, "1", ("drive",), ("plate01",), True, words=words, scale=(1.0, 7.0))
    means = {"plate01": np.array([1.0, 0.0, 0.5])}
    return run("touch", Humming(kind, means), kind, "signal", takes=("vibration",))


def rater(kind=None):
    kind = kind or SignalKind(100.0, "1", ("drive",), (), True, words=WORDS, scale=(1.0, 7.0))
    return run("judge", Judge(None, kind), kind, "scores", needs=())
