"""Forms by the conditions of models, and requests entered in them."""

import json
import shlex
import sys
from dataclasses import asdict, replace

import numpy as np
import pytest

from tactogram import models
from tactogram.datasets.ratings.words import WORDS
from tactogram.errors import ParameterError
from tactogram.model import ImageKind, SignalKind
from tactogram.signal import Image
from tactogram.signal.io import read_image, write_image
from tactogram_studio.generation.form import (
    GenerationForm,
    GenerationRequest,
    adapted,
    check_request,
    command,
    form_of,
    form_of_run,
    word_label,
)
from tactogram_studio.generation.runs import (
    GeneratingRuns,
)
from tactogram_studio.generation.state import MakePageState
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.shelf import ResultArchive

MATERIALS = ("cork", "felt", "tile")


SIGNALS = SignalKind(1000.0, "m/s^2", ("x", "y", "z"), MATERIALS, words=WORDS, scale=(1.0, 7.0))


IMAGES = ImageKind(WORDS, (0.0, 1.0), ("a",))


MODELS = {f"{f.name}-{f.learns_from}": f for found in models.available().values() for f in found.faces}


def kind_of(facts):
    return IMAGES if facts.gives == "image" else SIGNALS


def asked(run="", **values):
    """Return a request with values."""
    return GenerationRequest(run).changed(**values)


@pytest.mark.parametrize("name", [n for n, f in MODELS.items() if f.task == "generation"])
def test_a_form_has_every_condition(name):
    facts = MODELS[name]

    form = form_of(facts, kind_of(facts))

    assert {*form.needs, *form.takes, *form.instead, *form.drawn} == {*facts.conditions}
    assert set(form.drawn) == {"latent"} & {*facts.conditions}
    assert form.materials == (MATERIALS if form.has("material") else ())
    assert form.words == (WORDS if form.has("words") else ())


CONDITION = """
from tactogram.model import ConditionOption, ConditionType

CONDITION = ConditionType(
    "temperature_c",
    "temperature of the finger, °C",
    (ConditionOption("temperature", float, "temperature of the finger, °C"),),
    "°C",
)
"""


def test_a_condition_of_one_file_is_in_the_form_the_command_and_the_title(tmp_path, monkeypatch):
    (tmp_path / "temperature.py").write_text(CONDITION, encoding="utf-8")
    monkeypatch.setenv("TACTOGRAM_CONDITIONS", str(tmp_path / "temperature.py"))
    model = MODELS["ar_texture-recordings"]
    form = form_of(model.model_copy(update={"takes": (*model.takes, "temperature_c")}), SIGNALS)
    request = adapted(asked("r", temperature_c=31.5, contactor="finger"), form)

    assert request.values == {"material": {"cork": 1.0}, "temperature_c": 31.5}
    assert "--mix cork=1 --temperature 31.5 --seed" in command(request, form)
    assert request.title == "cork, 31.5 °C"
    sys.modules.pop("temperature", None)


@pytest.mark.parametrize("name", [n for n, f in MODELS.items() if f.task != "generation"])
def test_a_model_that_generates_nothing_has_no_form(name):
    with pytest.raises(ParameterError, match="generates nothing"):
        form_of(MODELS[name], SIGNALS)


@pytest.mark.parametrize("name", [n for n, f in MODELS.items() if f.task == "generation"])
def test_a_request_adapts_to_any_form(name):
    everything = asked(
        "runs/a",
        material={"cork": 0.5, "gone": 0.5},
        words={"rough": 6.0, "gone": 1.0},
        image="p.png",
        crop=(0, 0, 1, 1),
        vibration="v.npz",
        vibration_speed_mm_s=80.0,
        vibration_force_n=0.5,
        motion="simulated",
        speed_mm_s=100.0,
        force_n=1.0,
        seconds=2.0,
    )
    facts = MODELS[name]
    form = form_of(facts, kind_of(facts))

    request = adapted(everything, form)

    check_request(request, form)
    assert "gone" not in {**request.weights, **request.words}
    assert all(form.has(name) for name in request.values)
    for stated in ("image", "speed_mm_s", "motion", "vibration_force_n"):
        assert (stated in request.values) == form.has(stated)
    assert (request.seconds is not None) == (form.over == "time")


def test_weights_are_divided_by_their_sum():
    request = asked(material={"cork": 0.6, "felt": 0.0, "tile": 0.6})

    assert request.mix == {"cork": 0.5, "tile": 0.5}


MIX = GenerationForm(("material",), ("speed_mm_s", "force_n"), MATERIALS)


PHOTO = GenerationForm(("image",), ("material",), MATERIALS)


DESCRIBED = GenerationForm(("material",), ("speed_mm_s",), MATERIALS, instead=("image", "vibration"))


BY_WORDS = GenerationForm(("words",), ("vibration",), words=WORDS)


@pytest.mark.parametrize(
    ("form", "request_", "message"),
    [
        (MIX, asked(material={"cork": 0.0}), "at least one"),
        (PHOTO, asked(), "photograph"),
        (MIX, asked(material={"cork": 1}, seconds=61.0), "at most 60 s"),
        (MIX, asked(material={"cork": 1}, count=9), "1 to 8"),
    ],
)
def test_a_bad_request_is_refused_with_a_reason(form, request_, message):
    with pytest.raises(ParameterError, match=message):
        check_request(request_, form)


def test_a_request_survives_json():
    values = {"material": {"cork": 0.3}, "words": {"dry": 2.5}, "vibration": "v.npz", "force_n": 0.8}
    request = GenerationRequest("r", values, (0.1, 0.2, 0.9, 1.0), 1.5, 7, 2)

    assert GenerationRequest.from_stored(json.loads(json.dumps(asdict(request)))) == request


@pytest.mark.parametrize(
    "stored", [{"crop": "no", "values": 3}, {"values": {"material": 3}}, {"unknown": 1}, {}]
)
def test_malformed_values_become_defaults(stored):
    assert GenerationRequest.from_stored(stored) == GenerationRequest()


def test_the_command_has_all_settings_of_a_mix():
    request = asked(
        "runs/a b",
        material={"cork": 1.0, "tile": 2.0},
        speed_mm_s=80.0,
        force_n=0.5,
        seconds=1.5,
        seed=3,
        count=2,
    )

    words = shlex.split(command(request, MIX))

    assert words[:3] == ["tactogram", "generate", "runs/a b"]
    mix = dict(part.split("=") for part in words[words.index("--mix") + 1].split(","))
    assert {name: float(value) for name, value in mix.items()} == request.mix  # to the last digit
    assert " ".join(words[5:]) == "--speed 80 --force 0.5 --seconds 1.5 --seed 3 --count 2 --out made.wav"


def test_the_command_fills_in_missing_words_only():
    some = asked("r", words={"rough": 6.0})
    every = asked("r", words=dict.fromkeys(WORDS, 4.0), vibration="v.npz")

    assert shlex.split(command(some, BY_WORDS))[3:7] == ["--words", "rough=6", "--rest", "mean"]
    assert "--rest" not in command(every, BY_WORDS)
    assert "--vibration v.npz" in command(every, BY_WORDS)


def test_the_command_has_the_cropped_photograph():
    request = asked("r", material={"cork": 1.0}, image="whole.png", crop=(0, 0, 0.5, 0.5))

    assert "--material cork --image part.png" in command(request, PHOTO, image="part.png")


def test_the_command_has_the_speed_and_force_of_a_recording_while_one_is_used():
    form = replace(DESCRIBED, takes=("speed_mm_s", "vibration_speed_mm_s", "vibration_force_n"))
    request = asked(
        "r",
        material={"cork": 1.0},
        vibration="v.npz",
        vibration_speed_mm_s=80.0,
        vibration_force_n=0.5,
        speed_mm_s=150.0,
    )
    options = "--vibration v.npz --speed 150 --vibration-speed 80 --vibration-force 0.5"

    assert options in command(form.used(request), form)
    for unused in (request.changed(vibration=""), request.changed(image="p.png")):
        assert "vibration" not in command(form.used(unused), form)


def test_a_motion_replaces_speed_and_force():
    form = replace(DESCRIBED, takes=("speed_mm_s", "force_n", "motion"))
    request = asked("r", material={"cork": 1.0}, speed_mm_s=150.0, force_n=1.0)

    for motion, title in (("studio/motions/hand-1a2b3c4d.csv", "hand"), ("simulated", "a simulated hand")):
        moved = form.used(request.changed(motion=motion))
        assert f"--mix cork=1 --motion {motion} --seed" in command(moved, form)
        assert moved.title == f"cork, motion of {title}"
    assert "--speed 150 --force 1" in command(form.used(request), form)


def test_words_replace_materials_where_a_model_allows_it():
    form = replace(DESCRIBED, instead=("image", "vibration", "words"), words=WORDS)
    request = asked("r", material={"cork": 1.0}, words={"rough": 6.0})

    assert shlex.split(command(form.used(request), form))[3:] == [
        *("--words", "rough=6", "--seed", "0", "--out", "made.wav")
    ]
    assert "--words" not in command(form.used(request.changed(vibration="v.npz")), form)
    assert "--mix cork=1" in command(form.used(request.changed(words={})), form)


def test_without_materials_something_must_describe_the_surface():
    form = replace(DESCRIBED, instead=("image", "vibration", "words"), materials=(), words=WORDS)
    request = adapted(asked("r", material={"cork": 1.0}), form)

    assert [part for part in ("image", "words", "material", "vibration") if form.shows(part)] == [
        "words",
        "vibration",
    ]
    with pytest.raises(ParameterError, match="Describe the surface"):
        check_request(request, form)
    check_request(request.changed(words={"rough": 6.0}), form)


def test_words_are_in_both_languages():
    assert word_label("rough") == "rough  ざらざらする"
    assert word_label("other") == "other"


def test_a_photograph_or_recording_replaces_the_materials():
    request = asked("runs/a", material={"cork": 1.0}, image="p-1a.png", vibration="v-2b.npz")

    by_photo = DESCRIBED.used(request)
    by_recording = DESCRIBED.used(request.changed(image=""))
    by_material = DESCRIBED.used(request.changed(image="", vibration=""))

    assert "--image p-1a.png --seed" in command(by_photo, DESCRIBED)
    assert "a --vibration v-2b.npz --seed" in command(by_recording, DESCRIBED)
    assert "a --mix cork=1 --seed" in command(by_material, DESCRIBED)
    assert [r.title for r in (by_photo, by_recording, by_material)] == ["p", "v", "cork"]
    for used in (by_photo, by_recording, by_material):
        check_request(used, DESCRIBED)
    with pytest.raises(ParameterError, match="weight of at least one material"):
        check_request(asked("runs/a"), DESCRIBED)
    assert PHOTO.used(request) == request


@pytest.fixture
def state(workspace):
    """Give the state of a new page."""
    return state_of(workspace)


def state_of(folder):
    place = Workspace.at(folder)
    return MakePageState(place, ResultArchive(place.studio_folder / "kept"), GeneratingRuns(place), {})


def test_a_photograph_is_offered_in_place_of_a_material_where_some_were_trained_on(state):
    [run] = [run for run in state.runs.finished() if run.name == "texture_flow"]
    for photographs, offered in ({}, False), ({"train": 0, "test": 3}, False), ({"train": 3}, True):
        seen = replace(run, data={"name": "surfaces", "photographs": photographs})
        assert ("image" in form_of_run(seen).instead) == offered


def test_what_is_outside_of_what_was_learned_is_said_of_a_result(state, tmp_path):
    name = state.form.materials[0]
    request = state.request.changed(material={name: 1.0}, speed_mm_s=900.0)
    [(_, made)] = state.runs.generate(request)
    result = state.store_result(request, state.run, 1, made, state.runs.said(request))
    [sentence] = result.facts["limited"]
    assert sentence.startswith(f"speed 900 mm/s is outside of what was recorded of {name}: it counts as ")
    assert state.runs.said(request.changed(speed_mm_s=None)) == {"described": ""}
    shipped = asked("texture_flow", material={"cork": 1.0}, motion="simulated", seconds=2.0)
    assert "of the motion, is outside of" in state.runs.said(shipped)["limited"][0]


def test_a_text_is_the_materials_named_or_refused(state):
    everyday = asked("texture_flow", material={"cork": 1.0})
    assert state.runs.described(everyday, "Corrugated cardboard").weights == {"corrugated-cardboard": 1.0}
    blanket = state.runs.described(everyday, "a wool blanket")
    assert blanket.weights == {"wool-knit": 1.0}
    assert "text" not in blanket.values
    with pytest.raises(ParameterError, match="text must name a material or an effect that is known"):
        state.runs.described(everyday, "xyzzy")
    said = state.runs.said(blanket.changed(text="a wool blanket"))  # of another run, where it was predicted
    assert said["described"] == "Described: wool-knit 1; not understood: blanket."


def test_a_result_is_called_as_it_was_typed_until_the_mix_changes(state):
    everyday = asked("texture_flow", material={"cork": 1.0})
    typed = state.runs.described(everyday, "wet sandpaper")
    assert typed.title == "wet sandpaper: sandpaper"
    assert adapted(typed, form_of_run(state.runs.get("texture_flow"))).title == typed.title
    assert GenerationRequest.from_stored(json.loads(json.dumps(asdict(typed)))).title == typed.title
    assert typed.changed(speed_mm_s=120.0).title == "wet sandpaper: sandpaper, 120 mm/s"
    assert typed.changed(material={"sandpaper": 1.0, "cork": 1.0}).title == "sandpaper 0.5 + cork 0.5"
    assert state.runs.described(everyday, "Corrugated cardboard").title == "corrugated-cardboard"


def test_a_cropped_photograph_is_a_file_for_the_command(state):
    pixels = np.arange(40 * 60 * 3, dtype=np.uint8).reshape(40, 60, 3)
    write_image(state.photographs / "stone-1.png", Image(pixels))
    request = asked(image="studio/photos/stone-1.png", crop=(0.5, 0.25, 1.0, 0.75))

    name = state.runs.photo_file(request)

    part = read_image(state.workspace.inside(name))
    assert np.array_equal(part.pixels, pixels[10:30, 30:60])
    assert state.runs.photo_file(request) == name
    assert state.runs.photo_file(request.changed(crop=None)) == request.values["image"]
