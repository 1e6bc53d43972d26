"""Materials described in English: to weights, to files, and what is refused."""

import json
import shlex
import shutil
import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from tactogram.cli import main
from tactogram.datasets import Recording, create_store
from tactogram.datasets.simulate.materials import SYNONYMS
from tactogram.datasets.store.photographs import photograph_of
from tactogram.errors import MissingExtraError, ParameterError
from tactogram.features import text_classifier
from tactogram.features.text_classifier import describe
from tactogram.signal import Image, Signal
from tactogram.signal.io import read_metadata, read_signal, write_image
from tactogram.workflows.generation.generate import generate, generate_files, with_materials
from tactogram.workflows.training.loaded_run import load_run
from tactogram.workflows.training.train import train
from tactogram_studio.generation.runs import GeneratingRuns
from tactogram_studio.generation.state import MakePageState
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.shelf import ResultArchive

MATERIALS = load_run("texture_flow").kind.materials


@pytest.mark.parametrize(
    ("condition", "options", "message"),
    [
        ("cork", {}, "condition must be Mapping"),
        ({"material": {"no such": 1}}, {}, "material must be one of"),
        ({"colour": 1}, {}, "condition 'colour' is not one this model takes"),
        ({"material": {"cork": 1}}, {"count": "many"}, "count must be int, got 'many'"),
        ({"material": {"cork": 1}}, {"seconds": -1}, "seconds must be > 0"),
    ],
)
def test_the_call_itself_refuses_what_is_wrong(condition, options, message):
    with pytest.raises(ParameterError, match=message):
        generate("texture_flow", condition, **options)


@pytest.mark.parametrize(
    ("text", "material"),
    [
        ("Corrugated cardboard", "corrugated-cardboard"),
        ("a sheet of paper", "printer-paper"),
        ("bark of an oak tree", "tree-bark"),
        ("blue jeans", "denim"),  # by another name
        ("tarmac", "asphalt"),
    ],
)
def test_a_text_describes_the_material_most_like_it(text, material):
    weights = describe(text, MATERIALS, synonyms=SYNONYMS)
    assert next(iter(weights)) == material
    assert weights[material] > 0.5
    assert sum(weights.values()) == pytest.approx(1, abs=1e-3)


def test_what_is_like_several_materials_is_a_mix_of_them():
    weights = describe("sandpaper or cork", ["cork", "sand_paper", "tile"], synonyms={})
    assert weights.keys() == {"cork", "sand_paper"}


@pytest.mark.parametrize("text", ["happiness", "quantum mechanics", "xqzw"])
def test_what_is_like_none_is_refused(text):
    with pytest.raises(ParameterError, match="is like none of the 84; the nearest are"):
        describe(text, MATERIALS, synonyms=SYNONYMS)


def test_a_described_material_is_that_material():
    described, named = (
        next(generate("texture_flow", {**given, "speed_mm_s": 100.0}, seconds=1)).samples
        for given in ({"text": "corduroy trousers"}, {"material": "corduroy"})
    )
    assert (described == named).all()


def test_a_file_tells_what_was_described_and_what_was_taken(tmp_path, capsys):
    out = tmp_path / "x.wav"
    told = ["generate", "texture_flow", "--text", "lego bricks", "--seconds", "1", "--out", str(out)]
    assert main([*told, "--json"]) == 0
    [written] = json.loads(capsys.readouterr().out)["files"]
    assert written["text"] == "lego bricks"
    assert written["material"] == {"studded-plastic": 1.0}
    assert main(told) == 0
    assert "described: studded-plastic 1" in capsys.readouterr().out


def test_a_surface_is_described_once_and_by_a_run_that_knows_materials():
    run = load_run("texture_flow")
    assert with_materials(run, {"material": "silk", "speed_mm_s": 9.0}) == {
        "material": "silk",
        "speed_mm_s": 9.0,
    }
    with pytest.raises(ParameterError, match="'material' and 'text' describe the surface twice"):
        with_materials(run, {"text": "silk", "material": "silk"})
    for text in ("", " ", 5):
        with pytest.raises(
            ParameterError, match="text must describe a material, e.g. 'corrugated cardboard'"
        ):
            with_materials(run, {"text": text})


def test_without_the_extra_it_says_what_to_install(monkeypatch):
    text_classifier._encoder.cache_clear()
    monkeypatch.setitem(sys.modules, "wordllama", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'tactogram\[text\]'"):
        describe("silk", ["silk"], synonyms={})


# -- a library of one's own ----------------------------------------------------------------------------------

GRAINS = dict(
    zip(
        (
            "silk", "velvet", "cotton_fabric", "linen_cloth", "satin", "cashmere",
            "granite", "limestone", "marble", "sandstone", "slate", "basalt",
        ),
        np.linspace(0.5, 4.0, 12),
        strict=True,
    )
)  # fmt: skip
"""Simulated: the coarser a material looks, in pixels, the louder it feels."""


def photograph(grain, seed):
    noise = gaussian_filter(np.random.default_rng(seed).standard_normal((224, 224)), grain)
    grey = np.clip(0.5 + 0.12 * noise / noise.std(), 0, 1)
    return Image(np.uint8(255 * np.repeat(grey[..., None], 3, axis=2)))


def library(folder, looks):
    def recording(number, grain, name):
        x = np.random.default_rng(number).standard_normal((1, 2000))
        signal = Signal(0.03 * 2.4**grain * x, 1000.0, "m/s^2", ("z",))
        return Recording(streams={"acceleration": signal}, material=name, simulated=True)

    store = create_store(
        folder / "store",
        [recording(10 * k + turn, g, n) for k, (n, g) in enumerate(GRAINS.items()) for turn in range(2)],
        name="library",
        licence="none",
        simulated=True,
        photographs=[(name, photograph(grain, k)) for k, (name, grain) in enumerate(looks.items())],
    )
    return train(
        "texture_flow", store.path, recipe="tiny", split="all", out=folder / "run", accelerator="cpu"
    )


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    return library(tmp_path_factory.mktemp("own"), GRAINS).folder


def generated(run, tmp_path, capsys, *described):
    out = tmp_path / "x.wav"
    (tmp_path / "coarse.png").write_bytes(photograph_of(photograph(3.7, 99)).data)
    assert main(["generate", str(run), "--seconds", "1", *described, "--out", str(out)]) == 0
    return capsys.readouterr().out, read_metadata(out), read_signal(out).samples.std()


def test_photograph_and_text_predict_a_surface_that_the_run_does_not_know(own, tmp_path, capsys):
    image = ("--image", str(tmp_path / "coarse.png"))
    printed, facts, level = generated(own, tmp_path, capsys, *image, "--text", "flint stone")
    assert "predicted from the photograph and text, which explains " in printed
    assert "of the variance of this run's 12 materials, each left out; standard deviation " in printed
    assert (facts["text"], facts["prediction"]["given"]) == ("flint stone", ["image", "text"])
    assert facts["prediction"]["mean"] is False
    assert "material" not in facts
    assert level == pytest.approx(0.03 * 2.4**3.7, rel=0.5)
    printed, facts, level = generated(own, tmp_path, capsys, *image)
    assert "predicted from the photograph, which explains" in printed
    printed, facts, _ = generated(own, tmp_path, capsys, "--text", "flint stone")
    assert facts["prediction"]["given"] == ["text"]
    assert "the text" in printed


def test_the_exact_name_of_a_known_material_gives_that_material(own, tmp_path, capsys):
    printed, facts, level = generated(own, tmp_path, capsys, "--text", "Cotton fabric")
    assert "described: cotton_fabric 1" in printed
    assert facts["material"] == {"cotton_fabric": 1.0}
    assert "prediction" not in facts
    assert level == pytest.approx(0.03 * 2.4 ** GRAINS["cotton_fabric"], rel=0.3)


@pytest.mark.parametrize(("text", "unlike"), [("xyzzy", True), ("flint stone", False)])
def test_a_run_that_predicts_says_of_a_text_that_it_is_like_no_known_name(
    own, tmp_path, capsys, text, unlike
):
    printed, facts, _ = generated(own, tmp_path, capsys, "--text", text)
    assert facts["prediction"]["unlike"] is unlike
    assert ("the text is like no material's name" in printed) is unlike


@pytest.mark.parametrize("photographed", [False, True])
def test_the_page_make_generates_from_text_and_photograph_as_the_command_line_does(
    own, tmp_path, capsys, monkeypatch, photographed
):
    workspace = Workspace(tmp_path)
    shutil.copytree(own, tmp_path / "runs/own")
    write_image(tmp_path / "coarse.png", photograph(3.7, 99))
    state = MakePageState(workspace, ResultArchive(tmp_path / "shelf"), GeneratingRuns(workspace), {})
    state.choose("runs/own")
    state.set(photo="coarse.png" * photographed, seconds=0.5, seed=3)
    assert state.runs.described(replace(state.request, photo=""), "slate").weights == {"slate": 1.0}
    asked = state.runs.described(state.request, "flint stone")
    assert asked.text == "flint stone"
    state.set(text=asked.text)
    [(_, made)] = state.runs.generate(state.request)
    said = state.runs.said(state.request)
    assert said["prediction"]["given"] == (["image", "text"] if photographed else ["text"])
    assert said["described"].startswith(
        "Predicted from the photograph and text, which" if photographed else ""
    )
    assert "the text" in said["described"] or photographed
    monkeypatch.chdir(tmp_path)
    command = shlex.split(state.command())[1:-1]
    assert ("--text" in command, "--image" in command, "--mix" in command) == (True, photographed, False)
    assert main([*command, "made.npz"]) == 0
    assert capsys.readouterr().out.lower().count(said["described"][:-1].lower()) == 1
    np.testing.assert_array_equal(read_signal("made.npz").samples, made.samples)


def test_what_tells_nothing_gives_the_mean_and_the_file_says_so(tmp_path, capsys):
    grains = np.random.default_rng(2).permutation(list(GRAINS.values()))
    run = library(tmp_path, dict(zip(GRAINS, grains, strict=True))).folder
    printed, facts, level = generated(run, tmp_path, capsys, "--image", str(tmp_path / "coarse.png"))
    assert (
        "the mean of all materials was generated, as the photograph may tell nothing: it explains" in printed
    )
    assert facts["prediction"]["mean"] is True
    assert level == pytest.approx(0.03 * 2.4 ** np.mean(list(GRAINS.values())), rel=0.5)


def test_an_everyday_material_says_what_it_was_set_from(tmp_path):
    [made] = generate_files("texture_flow", {"material": "cork"}, tmp_path / "cork.wav", seconds=0.5)
    assert list(made["set_from"]) == ["cork"]
    assert "the mean of 60 real materials" in made["set_from"]["cork"]
