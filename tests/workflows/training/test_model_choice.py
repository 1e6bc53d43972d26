"""The model of a training by what it will be given: closest where a material is known, else what takes the rest."""

import json

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.datasets import Ratings, Recording, create_store, open_store
from tactogram.datasets.ratings.ratings import EVOKED
from tactogram.errors import ParameterError
from tactogram.signal import Image, Signal
from tactogram.workflows.training.model_choice import model_choice
from tactogram.workflows.training.train import train


def stored(folder, *, rate=1000.0, domain="time", recorded=True, **more):
    rng = np.random.default_rng(0)
    signals = [Signal(rng.standard_normal((1, 2000)), rate, "m/s^2", domain=domain) for _ in range(8)]
    recordings = [
        Recording(streams={"acceleration": signal}, material=("cork", "tile")[number % 2], simulated=True)
        for number, signal in enumerate(signals)
    ]
    store = create_store(
        folder / "store", recordings if recorded else [], name="s", licence="-", simulated=True, **more
    )
    return open_store(store.path)


PHOTOGRAPHS = [
    (name, Image(np.full((64, 64, 3), level, np.uint8))) for name, level in (("cork", 9), ("tile", 99))
]
RATINGS = Ratings(["a", "a"], ["cork", "tile"], ["rough", "rough"], np.array([0.0, 1.0]), EVOKED)


def test_known_materials_are_for_the_closest_model(tmp_path):
    model, recipe, why = model_choice("generate", stored(tmp_path))
    assert (model, recipe) == ("texture_var", "quick")
    assert why.endswith("texture_flow also takes other speeds and forces")


def test_what_else_a_store_has_is_said_and_chosen_when_asked_for(tmp_path):
    store = stored(tmp_path, photographs=PHOTOGRAPHS, ratings=RATINGS)
    model, _, why = model_choice("generate", store)
    assert model == "texture_var"
    assert why.endswith("texture_flow also takes other speeds and forces, photographs, words")
    assert model_choice("photograph", store)[:2] == ("texture_flow", "quick")
    assert model_choice("words", store)[:2] == ("texture_flow", "quick")
    assert model_choice("rating", store)[:2] == ("rater", "quick")
    assert model_choice("words", store, label="item")[:2] == ("texture_flow", "rated")


def test_what_the_closest_model_cannot_learn_is_for_the_other(tmp_path):
    images = {"recorded": False, "photographs": PHOTOGRAPHS, "ratings": RATINGS}
    for number, (kind, recipe) in enumerate(
        [({"domain": "displacement"}, "friction"), ({"rate": 330.0}, "quick"), (images, "image")]
    ):
        store = stored(tmp_path / str(number), **kind)
        assert model_choice("generate", store)[:2] == ("texture_flow", recipe)


@pytest.mark.parametrize(
    ("rate", "chosen"), [(100.0, "ar_texture"), (230.0, "texture_flow"), (800.0, "texture_var")]
)
def test_the_model_of_a_low_rate_can_learn_from_it(rate, chosen, tmp_path):
    store = stored(tmp_path, rate=rate)
    model, recipe, _ = model_choice("generate", store)
    assert model == chosen
    if model != "texture_var":
        with pytest.raises(
            ParameterError, match=r"rate must be at least 800 Hz, got .*; ar_texture takes any rate"
        ):
            train("texture_var", store.path, out=tmp_path / "refused")
    changes = {"config.steps": 1} if model == "texture_flow" else {}
    train(model, store.path, recipe=recipe, out=tmp_path / "run", changes=changes)
    assert (tmp_path / "run" / "model.json").is_file()


@pytest.mark.parametrize(
    ("purpose", "lacking"), [("photograph", "photographs"), ("words", "ratings"), ("rating", "ratings")]
)
def test_a_store_without_what_it_is_for_is_refused(purpose, lacking, tmp_path):
    with pytest.raises(ParameterError, match=f"{purpose} needs a store with {lacking}, .* has none"):
        model_choice(purpose, stored(tmp_path))


def test_the_command_trains_the_model_chosen_and_says_which(tmp_path, capsys):
    told = ["train", "--data", str(stored(tmp_path).path), "--out", str(tmp_path / "run"), "--quiet"]
    assert main([*told, "--for", "generate", "--json"]) == 0
    assert "note: texture_var: closest to recordings of a known material" in capsys.readouterr().err
    assert json.loads((tmp_path / "run" / "model.json").read_text())["model"] == "texture_var"
    assert main([*told, "--for", "words"]) == 1
    assert "--for words needs a store with ratings" in capsys.readouterr().err
    for wrong in ([], ["ar_texture", "--for", "generate"]):
        assert main([*told, *wrong]) == 2
        assert "needs --data DIR and MODEL or --for" in capsys.readouterr().err
    assert main(["train", "--resume", str(tmp_path / "run"), "--for", "generate"]) == 2
    assert "omit --for" in capsys.readouterr().err
