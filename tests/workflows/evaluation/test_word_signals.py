"""A generator by words beside the nearest signal, judged by a rater model."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_ratings import FACTS, RATE, WORDS, rated_store, ratings_of, vibration

from tactogram.datasets import Recording, Scale, create_store
from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.workflows.evaluation.evaluate import evaluate
from tactogram.workflows.evaluation.word_signals import generate_rated_surfaces
from tactogram.workflows.training.train import train


def strain(seed):
    return Signal(np.random.default_rng(seed).standard_normal((2, 500)), RATE, "V", ("g1", "g2"))


def plates_and_signals(path):
    levels = {f"s{n}": float(10 ** -(n / 8)) for n in range(12)} | {
        "plate1": 0.9,
        "plate2": 0.05,
        "plate3": 0.3,
    }
    signals = [
        Recording(streams={"drive": vibration(levels[f"s{n}"], n)}, labels={"item": f"s{n}"}, source=f"s{n}")
        for n in range(12)
    ]
    plates = [
        Recording(
            streams={"strain": strain(10 * p + m)},
            material=f"plate{p}",
            session=f"plate{p}-m{m}",
            source=f"plate{p}/{m}",
        )
        for p in (1, 2, 3)
        for m in range(5)
    ]
    return create_store(path, plates + signals, ratings=ratings_of(levels), **FACTS).path


def test_a_generator_by_words_is_judged_by_a_rater_model_beside_the_sensor_and_the_nearest_signal(
    rater_run, tmp_path
):
    data = plates_and_signals(tmp_path / "s")
    trained = train(
        "ultrasonic_cgan", data, recipe="tiny", by="session", out=tmp_path / "run", accelerator="cpu",
        changes={"config.clusters": 1},
    )  # fmt: skip
    made = generate_rated_surfaces(trained.folder)
    assert set(made.signals) == set(made.targets) == set(made.straight) == {"plate1", "plate2", "plate3"}
    assert all(np.abs(one.samples).max() == 1 for one in made.straight.values())
    assert len(made.nearest["plate1"]) == 400
    with pytest.raises(ParameterError, match="give a run of the model rater .* as `rater`"):
        evaluate(trained.folder)
    found = evaluate(trained.folder, rater=rater_run)
    assert set(found["conditions"]) == {"sensor", "nearest", "run"}
    assert found["told_by"] == "a rater model of simulated raters"
    assert found["conditions"]["nearest"]["mae"] < found["conditions"]["sensor"]["mae"]

    turned = rated_store(tmp_path / "turned", change=lambda ratings: ratings.in_words(WORDS[::-1]))
    rater = train("rater", turned, recipe="tiny", out=tmp_path / "turned-run", accelerator="cpu").folder
    again = evaluate(trained.folder, rater=rater)
    for name, row in found["conditions"].items():
        assert again["conditions"][name]["mae"] == pytest.approx(row["mae"], rel=1e-6), "words by their names"

    other = rated_store(
        tmp_path / "other", change=lambda ratings: replace(ratings, scale=Scale("wide", 0.0, 10.0))
    )
    rater = train("rater", other, recipe="tiny", out=tmp_path / "other-run", accelerator="cpu").folder
    with pytest.raises(ParameterError, match=r"on the scale of the surfaces, 1 to 7, got \(0.0, 10.0\)"):
        evaluate(trained.folder, rater=rater)
