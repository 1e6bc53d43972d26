"""Materials described in English: to weights, to files, and what is refused."""

import json
import sys

import pytest

from tactogram.cli import main
from tactogram.datasets.simulate.everyday import SYNONYMS
from tactogram.errors import MissingExtraError, ParameterError
from tactogram.features import text_classifier
from tactogram.features.text_classifier import describe
from tactogram.workflows.generation.descriptions import with_materials
from tactogram.workflows.generation.generate import generate
from tactogram.workflows.training.loaded_run import load_run

MATERIALS = load_run("texture_flow").kind.materials


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
    with pytest.raises(ParameterError, match="is like none of the 88; the nearest are"):
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
