"""Trainings of picture translators that train nothing: made-up workflows."""

import json
from types import SimpleNamespace

import numpy as np

from tactogram.datasets import Recording, create_store
from tactogram.signal import Signal


class MadeUpWorkflows:
    """Trains nothing: what a cell finds is a formula of what was asked."""

    def __init__(self):
        self.trained = []

    def simulate_to_store(self, name, out, *, seed, photographs, progress, **options):
        self.simulated = {"name": name, "photographs": photographs, **options}
        strokes = (
            Recording(
                streams={
                    "acceleration": Signal(np.random.default_rng(k).standard_normal((3, 50)), 100, "m/s^2")
                },
                material="cork",
                simulated=True,
            )
            for k in range(2)
        )
        create_store(out, strokes, name="made up", licence="-", simulated=True)

    def train(self, model, data, *, recipe, changes, split, out, resume, progress):
        self.trained.append((model, recipe, dict(changes)))
        self.split = split
        out.mkdir(parents=True)
        d, layers = (changes.get(f"config.{key}", 3) for key in ("discriminators", "layers"))
        validation = {"row_statistics_unseen": abs(d - 3) + abs(layers - 1), "label_accuracy_unseen": 1.0}
        figure = {"pix2pix": 0.5, "pix2pixhd": 0.4, "residue_fusion_gan": 0.3}.get(model, 0.2)
        noise = np.random.default_rng([changes["seed"], *model.encode()]).normal()
        changed = abs(d - 3) + abs(layers - 3) + (changes.get("config.l1") == 0.0)
        figure += 0.001 * noise + 0.1 * changed * (1 + 0.1 * changes["seed"])
        (out / "found.json").write_text(json.dumps(figure))
        return SimpleNamespace(facts=lambda: {"validation": validation})

    def evaluate_pictures(self, run, *, weights, most, progress):
        self.weights, self.most = weights, most
        figure = json.loads((run / "found.json").read_text())
        values = {"l1": figure, "log_spectral_distance_db": 10 * figure}
        return {"values": values, "missing": {"lpips": "no weights"}, "pictures": 8}
