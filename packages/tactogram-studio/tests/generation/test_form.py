"""Forms by the conditions of models, and requests entered in them."""

import json
import shlex
from dataclasses import asdict, replace

import numpy as np
import pytest

from tactogram import models
from tactogram.datasets.ratings.words import WORDS
from tactogram.errors import ParameterError
from tactogram.model import ImageKind, SignalKind
from tactogram.signal import Image
from tactogram.signal.io import write_image
from tactogram_studio.generation.form import (
    DRAWN,
    PARTS,
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


@pytest.mark.parametrize("name", [n for n, f in MODELS.items() if f.task == "generation"])
def test_a_form_has_a_part_for_every_condition(name):
    facts = MODELS[name]

    form = form_of(facts, kind_of(facts))

    assert {PARTS[c] for c in facts.needs if c not in DRAWN} == set(form.needs)
    assert {PARTS[c] for c in facts.takes if c not in DRAWN} == set(form.takes)
    assert {PARTS[c] for c in facts.instead} == set(form.instead)
    assert set(form.drawn) == {c for c in (*facts.needs, *facts.takes) if c in DRAWN}
    assert form.materials == (MATERIALS if form.has("materials") else ())
    assert form.words == (WORDS if form.has("words") else ())


@pytest.mark.parametrize("name", [n for n, f in MODELS.items() if f.task != "generation"])
def test_a_model_that_generates_nothing_has_no_form(name):
    with pytest.raises(ParameterError, match="generates nothing"):
        form_of(MODELS[name], SIGNALS)


@pytest.mark.parametrize("name", [n for n, f in MODELS.items() if f.task == "generation"])
def test_a_request_adapts_to_any_form(name):
    everything = GenerationRequest(
        "runs/a",
        weights={"cork": 0.5, "gone": 0.5},
        words={"rough": 6.0, "gone": 1.0},
        photo="p.png",
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
    assert bool(request.photo) == form.has("photo")
    assert (request.speed_mm_s is not None) == form.has("speed")
    assert bool(request.motion) == form.has("motion")
    assert (request.vibration_force_n is not None) == form.has("vibration_force")
    assert (request.seconds is not None) == (form.over == "time")


def test_weights_are_divided_by_their_sum_or_left_free():
    request = GenerationRequest(weights={"cork": 0.6, "felt": 0.0, "tile": 0.6})

    assert request.mix == {"cork": 0.5, "tile": 0.5}
    assert replace(request, to_one=False).mix == {"cork": 0.6, "tile": 0.6}


MIX = GenerationForm(("materials",), ("speed", "force"), MATERIALS)


PHOTO = GenerationForm(("photo",), ("materials",), MATERIALS)


DESCRIBED = GenerationForm(("materials",), ("speed",), MATERIALS, instead=("photo", "vibration"))


BY_WORDS = GenerationForm(("words",), ("vibration",), words=WORDS)


@pytest.mark.parametrize(
    ("form", "request_", "message"),
    [
        (MIX, GenerationRequest(weights={"cork": 0.0}), "at least one"),
        (PHOTO, GenerationRequest(), "photograph"),
        (MIX, GenerationRequest(weights={"cork": 1}, seconds=61.0), "at most 60 s"),
        (MIX, GenerationRequest(weights={"cork": 1}, count=9), "1 to 8"),
    ],
)
def test_a_bad_request_is_refused_with_a_reason(form, request_, message):
    with pytest.raises(ParameterError, match=message):
        check_request(request_, form)


def test_a_request_survives_json():
    request = GenerationRequest(
        "r",
        {"cork": 0.3},
        False,
        "coarse cork",
        {"dry": 2.5},
        "p.png",
        (0.1, 0.2, 0.9, 1.0),
        "v.npz",
        120.0,
        0.8,
        80.0,
        None,
        1.5,
        7,
        2,
    )

    assert GenerationRequest.from_stored(json.loads(json.dumps(asdict(request)))) == request


@pytest.mark.parametrize("stored", [{"crop": "no", "weights": 3}, {"unknown": 1}, {}])
def test_malformed_values_become_defaults(stored):
    assert GenerationRequest.from_stored(stored) == GenerationRequest()


def test_the_command_has_all_settings_of_a_mix():
    request = GenerationRequest(
        "runs/a b", {"cork": 1.0, "tile": 2.0}, speed_mm_s=80.0, force_n=0.5, seconds=1.5, seed=3, count=2
    )

    words = shlex.split(command(request, MIX))

    assert words[:3] == ["tactogram", "generate", "runs/a b"]
    mix = dict(part.split("=") for part in words[words.index("--mix") + 1].split(","))
    assert {name: float(value) for name, value in mix.items()} == request.mix  # to the last digit
    assert " ".join(words[5:]) == "--speed 80 --force 0.5 --seconds 1.5 --seed 3 --count 2 --out made.wav"


def test_the_command_fills_in_missing_words_only():
    some = GenerationRequest("r", words={"rough": 6.0})
    every = GenerationRequest("r", words=dict.fromkeys(WORDS, 4.0), vibration="v.npz")

    assert shlex.split(command(some, BY_WORDS))[3:7] == ["--words", "rough=6", "--rest", "mean"]
    assert "--rest" not in command(every, BY_WORDS)
    assert "--vibration v.npz" in command(every, BY_WORDS)


def test_the_command_has_the_cropped_photograph():
    request = GenerationRequest("r", {"cork": 1.0}, photo="whole.png", crop=(0, 0, 0.5, 0.5))

    assert "--material cork --image part.png" in command(request, PHOTO, photo="part.png")


def test_the_command_has_the_speed_and_force_of_a_recording_while_one_is_used():
    form = replace(DESCRIBED, takes=("speed", "vibration_speed", "vibration_force"))
    request = GenerationRequest(
        "r",
        {"cork": 1.0},
        vibration="v.npz",
        vibration_speed_mm_s=80.0,
        vibration_force_n=0.5,
        speed_mm_s=150.0,
    )
    options = "--vibration v.npz --vibration-speed 80 --vibration-force 0.5 --speed 150"

    assert options in command(form.used(request), form)
    for unused in (replace(request, vibration=""), replace(request, photo="p.png")):
        assert "vibration" not in command(form.used(unused), form)


def test_a_motion_replaces_speed_and_force():
    form = replace(DESCRIBED, takes=("speed", "force", "motion"))
    request = GenerationRequest("r", {"cork": 1.0}, speed_mm_s=150.0, force_n=1.0)

    for motion, title in (("studio/motions/hand-1a2b3c4d.csv", "hand"), ("simulated", "a simulated hand")):
        moved = form.used(replace(request, motion=motion))
        assert f"--mix cork=1 --motion {motion} --seed" in command(moved, form)
        assert moved.title == f"cork, motion of {title}"
    assert "--speed 150 --force 1" in command(form.used(request), form)


def test_words_replace_materials_where_a_model_allows_it():
    form = replace(DESCRIBED, instead=("photo", "vibration", "words"), words=WORDS)
    request = GenerationRequest("r", {"cork": 1.0}, words={"rough": 6.0})

    assert shlex.split(command(form.used(request), form))[3:] == [
        *("--words", "rough=6", "--seed", "0", "--out", "made.wav")
    ]
    assert "--words" not in command(form.used(replace(request, vibration="v.npz")), form)
    assert "--mix cork=1" in command(form.used(replace(request, words={})), form)


def test_without_materials_something_must_describe_the_surface():
    form = replace(DESCRIBED, instead=("photo", "vibration", "words"), materials=(), words=WORDS)
    request = adapted(GenerationRequest("r", {"cork": 1.0}), form)

    assert [part for part in ("photo", "words", "materials", "vibration") if form.shows(part)] == [
        "words",
        "vibration",
    ]
    with pytest.raises(ParameterError, match="Describe the surface"):
        check_request(request, form)
    check_request(replace(request, words={"rough": 6.0}), form)


def test_words_are_in_both_languages():
    assert word_label("rough") == "rough  ざらざらする"
    assert word_label("other") == "other"


def test_a_photograph_or_recording_replaces_the_materials():
    request = GenerationRequest("runs/a", weights={"cork": 1.0}, photo="p-1a.png", vibration="v-2b.npz")

    by_photo = DESCRIBED.used(request)
    by_recording = DESCRIBED.used(replace(request, photo=""))
    by_material = DESCRIBED.used(replace(request, photo="", vibration=""))

    assert "--image p-1a.png --seed" in command(by_photo, DESCRIBED)
    assert "a --vibration v-2b.npz --seed" in command(by_recording, DESCRIBED)
    assert "a --mix cork=1 --seed" in command(by_material, DESCRIBED)
    assert [r.title for r in (by_photo, by_recording, by_material)] == ["p", "v", "cork"]
    for used in (by_photo, by_recording, by_material):
        check_request(used, DESCRIBED)
    with pytest.raises(ParameterError, match="weight of at least one material"):
        check_request(GenerationRequest("runs/a"), DESCRIBED)
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
        assert ("photo" in form_of_run(seen).instead) == offered


def test_what_is_outside_of_what_was_learned_is_said_of_a_result(state, tmp_path):
    name = state.form.materials[0]
    asked = replace(state.request, weights={name: 1.0}, speed_mm_s=900.0)
    [(_, made)] = state.runs.generate(asked)
    result = state.store_result(asked, state.run, 1, made, state.runs.said(asked))
    [sentence] = result.facts["limited"]
    assert sentence.startswith(f"speed 900 mm/s is outside of what was recorded of {name}: it counts as ")
    assert state.runs.said(replace(asked, speed_mm_s=None)) == {"described": ""}
    shipped = GenerationRequest("texture_flow", {"cork": 1.0}, motion="simulated", seconds=2.0)
    assert "of the motion, is outside of" in state.runs.said(shipped)["limited"][0]


def test_a_text_is_the_material_named_a_mix_of_those_like_it_or_refused(state):
    everyday = GenerationRequest("texture_flow", {"cork": 1.0})
    assert state.runs.described(everyday, "Corrugated cardboard").weights == {"corrugated-cardboard": 1.0}
    blanket = state.runs.described(everyday, "a wool blanket")
    assert next(iter(blanket.weights)) == "wool-knit"
    assert blanket.text == ""
    with pytest.raises(ParameterError, match="'xyzzy' is like none of the 84; the nearest are"):
        state.runs.described(everyday, "xyzzy")
    said = state.runs.said(replace(blanket, text="a wool blanket"))  # of another run, where it was predicted
    assert said["described"] == f"Described: wool-knit {said['material']['wool-knit']:g}, scouring-pad " + (
        f"{said['material']['scouring-pad']:g}."
    )


def test_a_cropped_photograph_is_a_file_for_the_command(state):
    pixels = np.arange(40 * 60 * 3, dtype=np.uint8).reshape(40, 60, 3)
    write_image(state.photographs / "stone-1.png", Image(pixels))
    request = GenerationRequest(photo="studio/photos/stone-1.png", crop=(0.5, 0.25, 1.0, 0.75))

    name = state.photo_file(request)

    part = state.runs.photograph(GenerationRequest(photo=name))
    assert np.array_equal(part.pixels, pixels[10:30, 30:60])
    assert state.photo_file(request) == name
    assert state.photo_file(replace(request, crop=None)) == request.photo
