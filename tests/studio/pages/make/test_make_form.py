"""Forms from what models say of themselves, and what is asked with them."""

import json
import shlex

import pytest

from tactogram import models
from tactogram.datasets.ratings.words import WORDS
from tactogram.errors import ParameterError
from tactogram.model import ImageKind, SignalKind
from tactogram.models import ModelDescription
from tactogram.studio.pages.make.form import (
    DRAWN,
    FIELDS,
    FormHistory,
    GenerationForm,
    GenerationRequest,
    check,
    command,
    form_of,
    suited,
    word_label,
)
from tactogram.studio.pages.make.words_view import scale_text

MATERIALS = ("cork", "felt", "tile")
SIGNALS = SignalKind(1000.0, "m/s^2", ("x", "y", "z"), MATERIALS, words=WORDS, scale=(1.0, 7.0))
IMAGES = ImageKind(WORDS, (0.0, 1.0), ("a",))
MODELS = models.available()


def kind_of(facts):
    return IMAGES if facts.gives == "image" else SIGNALS


@pytest.mark.parametrize("name", [n for n, f in MODELS.items() if f.task == "generation"])
def test_a_form_has_a_part_for_every_condition(name):
    facts = MODELS[name]

    form = form_of(facts, kind_of(facts))

    assert {FIELDS[c] for c in facts.needs if c not in DRAWN} == set(form.needs)
    assert {FIELDS[c] for c in facts.takes if c not in DRAWN} == set(form.takes)
    assert set(form.own_seed) == {c for c in (*facts.needs, *facts.takes) if c in DRAWN}
    assert form.materials == (MATERIALS if form.has("materials") else ())
    assert form.words == (WORDS if form.has("words") else ())


@pytest.mark.parametrize("name", [n for n, f in MODELS.items() if f.task != "generation"])
def test_what_makes_nothing_has_no_form(name):
    with pytest.raises(ParameterError, match="makes nothing"):
        form_of(MODELS[name], SIGNALS)


@pytest.mark.parametrize("name", [n for n, f in MODELS.items() if f.task == "generation"])
def test_any_other_form_can_be_gone_over_to(name):
    everything = GenerationRequest(
        "runs/a",
        weights={"cork": 0.5, "gone": 0.5},
        words={"rough": 6.0, "gone": 1.0},
        photo="p.png",
        crop=(0, 0, 1, 1),
        vibration="v.npz",
        speed_mm_s=100.0,
        force_n=1.0,
        seconds=2.0,
    )
    facts = MODELS[name]
    form = form_of(facts, kind_of(facts))

    asked = suited(everything, form)

    check(asked, form)
    assert "gone" not in {**asked.weights, **asked.words}
    assert bool(asked.photo) == form.has("photo")
    assert (asked.speed_mm_s is not None) == form.has("speed")
    assert (asked.seconds is not None) == (form.over == "time")


def test_weights_are_divided_by_their_sum_or_left_free():
    asked = GenerationRequest(weights={"cork": 0.6, "felt": 0.0, "tile": 0.6})

    assert asked.mix == {"cork": 0.5, "tile": 0.5}
    assert asked.with_changes(to_one=False).mix == {"cork": 0.6, "tile": 0.6}


MIX = GenerationForm(("materials",), ("speed", "force"), MATERIALS)
PHOTO = GenerationForm(("photo",), ("materials",), MATERIALS)
BY_WORDS = GenerationForm(("words",), ("vibration",), words=WORDS)


@pytest.mark.parametrize(
    ("form", "asked", "said"),
    [
        (MIX, GenerationRequest(weights={"cork": 0.0}), "at least one"),
        (PHOTO, GenerationRequest(), "photograph"),
        (MIX, GenerationRequest(weights={"cork": 1}, speed_mm_s=-1.0), "Speed"),
        (MIX, GenerationRequest(weights={"cork": 1}, force_n=float("nan")), "Force"),
        (MIX, GenerationRequest(weights={"cork": 1}, seconds=61.0), "at most 60 s"),
        (MIX, GenerationRequest(weights={"cork": 1}, seed=-1), "Seed"),
        (MIX, GenerationRequest(weights={"cork": 1}, count=9), "1 to 8"),
        (BY_WORDS, GenerationRequest(words={"rough": 7.5}), "rough must be 1 to 7"),
        (PHOTO, GenerationRequest(photo="a.png", crop=(0.5, 0, 0.5, 1)), "width and a height"),
    ],
)
def test_what_cannot_be_made_is_said_in_a_sentence(form, asked, said):
    with pytest.raises(ParameterError, match=said):
        check(asked, form)


def test_a_form_survives_json():
    asked = GenerationRequest(
        "r", {"cork": 0.3}, False, {"dry": 2.5}, "p.png", (0.1, 0.2, 0.9, 1.0), "v.npz", 80.0, None, 1.5, 7, 2
    )

    assert GenerationRequest.of(json.loads(json.dumps(asked.as_dict()))) == asked


@pytest.mark.parametrize("held", [{"crop": "no", "weights": 3}, {"unknown": 1}, {}])
def test_what_is_not_understood_is_left_at_its_default(held):
    assert GenerationRequest.of(held) == GenerationRequest()


def test_the_command_line_says_all_of_a_mix():
    asked = GenerationRequest(
        "runs/a b", {"cork": 1.0, "tile": 2.0}, speed_mm_s=80.0, force_n=0.5, seconds=1.5, seed=3, count=2
    )

    words = shlex.split(command(asked, MIX))

    assert words[:3] == ["tactogram", "generate", "runs/a b"]
    mix = dict(part.split("=") for part in words[words.index("--mix") + 1].split(","))
    assert {name: float(value) for name, value in mix.items()} == asked.mix  # to the last digit
    assert words[5:] == [
        "--speed",
        "80",
        "--force",
        "0.5",
        "--seconds",
        "1.5",
        "--seed",
        "3",
        "--count",
        "2",
        "--out",
        "made.wav",
    ]


def test_the_command_line_fills_words_only_where_some_are_open():
    some = GenerationRequest("r", words={"rough": 6.0})
    every = GenerationRequest("r", words=dict.fromkeys(WORDS, 4.0), vibration="v.npz")

    assert shlex.split(command(some, BY_WORDS))[3:7] == ["--words", "rough=6", "--rest", "mean"]
    assert "--rest" not in command(every, BY_WORDS)
    assert "--vibration v.npz" in command(every, BY_WORDS)


def test_the_command_line_names_the_part_of_the_photograph():
    asked = GenerationRequest("r", {"cork": 1.0}, photo="whole.png", crop=(0, 0, 0.5, 0.5))

    assert "--material cork --image part.png" in command(asked, PHOTO, photo="part.png")


def test_words_are_in_both_languages():
    assert word_label("rough") == "rough  ざらざらする"
    assert word_label("other") == "other"


def test_history_goes_back_and_forth():
    history = FormHistory().after({"a": 1}).after({"a": 2})

    history, state = history.undone({"a": 3})
    assert state == {"a": 2}
    history, state = history.undone(state)
    assert state == {"a": 1}
    history, state = history.redone(state)
    assert state == {"a": 2}
    with pytest.raises(ParameterError, match="Nothing to redo"):
        history.after({"a": 2}).redone({"a": 9})
    with pytest.raises(ParameterError, match="Nothing to undo"):
        FormHistory().undone({})


def test_history_is_bounded():
    history = FormHistory()
    for number in range(200):
        history = history.after({"n": number})

    assert len(history.past) == FormHistory.MOST
    assert history.past[-1] == {"n": 199}


def test_an_unknown_condition_is_not_passed_over():
    facts = ModelDescription(
        title="t", authors=("a",), year=2020, task="generation", gives="signal", needs=("image",)
    )
    unknown = facts.model_copy(update={"needs": ("material",), "takes": ("latent",)})

    assert form_of(unknown, SIGNALS).own_seed == ("latent",)


def test_the_sliders_of_words_say_what_they_mean_for_the_runs_own_ratings():
    assert scale_text((1.0, 7.0)) == scale_text(None) == "1 (not at all) to 7 (very)."
    assert "4 one half, 7 everybody" in scale_text(IMAGES.scale)
    assert "own ratings are 0 to 100" in scale_text((0.0, 100.0))
