"""What a discriminator accepts in the sweep of display signals; nothing is trained."""

from types import SimpleNamespace

import numpy as np
import torch
from benchmarks.experiments import ultrasonic_cgan_signals

from tactogram.datasets import Ratings
from tactogram.datasets.ratings.words import WORDS


def rated(scores):
    rows = [
        (f"r{r:02d}", item, word, score)
        for r in range(20)
        for item, score in scores.items()
        for word in WORDS
    ]
    rater, item, word, score = zip(*rows, strict=True)
    return Ratings(rater, item, word, np.array(score, float), words=WORDS)


def accepted(monkeypatch, verdict):
    """Two seen and two unseen signals, whose spectra are 1 and 3; plates are rated 7, signals 1."""
    names = {"signal01": 1.0, "signal02": 1.0, "signal41": 3.0, "signal42": 3.0}
    monkeypatch.setattr(
        ultrasonic_cgan_signals, "_spectra", lambda: {n: np.full(4, x, np.float32) for n, x in names.items()}
    )
    surfaces = SimpleNamespace(display_scale=2.0, members=lambda cluster: ("plate01",))
    model = SimpleNamespace(surfaces=surfaces, trained=[SimpleNamespace(discriminator=verdict)])
    seen, unseen = rated({"signal01": 1, "signal02": 1}), rated({"signal41": 1, "signal42": 1})
    return ultrasonic_cgan_signals._known_by_heart(model, seen, unseen, rated({"plate01": 7, "plate02": 1}))


def test_a_discriminator_that_knows_its_spectra_by_heart_does_not_use_words(monkeypatch):
    found = accepted(monkeypatch, lambda x: torch.where(x[:, :1] == 0.5, 1.0, -1.0))
    assert found == {"accepted_seen": 1.0, "accepted_unseen": 0.0, "words_alone": 0.5}


def test_a_discriminator_of_words_accepts_every_signal(monkeypatch):
    found = accepted(monkeypatch, lambda x: torch.where(x[:, 4:].mean(1, keepdim=True) < 0.5, 1.0, -1.0))
    assert found == {"accepted_seen": 1.0, "accepted_unseen": 1.0, "words_alone": 1.0}
