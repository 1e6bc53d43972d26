"""Texts in English: what is understood of them, what is said not to be, and what is refused instead of invented."""

import pytest

from tactogram.errors import ParameterError
from tactogram.workflows.generation.text_understanding import material_in, understand
from tactogram.workflows.training.loaded_run import load_run

MATERIALS = load_run("texture_flow").kind.materials
NAMED = {
    "a sheet of paper": "printer-paper",
    "Corrugated cardboard": "corrugated-cardboard",
    "bark of an oak tree": "tree-bark",
    "blue jeans": "denim",
    "tarmac": "asphalt",
    "lego bricks": "studded-plastic",
    "an old brick wall": "brick",
    "steel wool": "scouring-pad",
    "rubber mat": "ribbed-rubber-mat",
    "a wooden table": "polished-wood",
    "rough wood": "rough-sawn-wood",
    "the feel of a leather sofa": "grained-leather",
    "sand paper": "sandpaper",
    "heartbeat": "heartbeat",
    "a heart beat": "heartbeat",
    "button press": "click",
    "double click": "double-click",
    "car engine": "engine",
    "the sound of rain": "rain",
    "phone call": "ringing",
}
NOT_NAMED = (
    "a cat",
    "my grandmother",
    "wet",
    "rough, sticky",
    "happiness",
    "quantum mechanics",
    "xqzw",
    "banana",
    "a dog",
    "a car",
    "bicycle",
    "water",
    "snow",
    "hair",
    "cheese",
    "a flower",
    "a drop of water",
    "seven",
    "クリック",
    "the",
)
MIXED = {
    "wet sandpaper": ("sandpaper", ("wet",)),
    "cardboard with wet ridges": ("cardboard", ("wet", "ridges")),
    "a cat on a carpet": ("loop-carpet", ("cat",)),
    "marble statue": ("polished-marble", ("statue",)),
    "rain on a tent": ("rain", ("tent",)),
    "a tent in the rain": ("canvas", ("rain",)),
    "wet, ridges": ("ridges", ("wet",)),
    "car park attendant": ("concrete", ("attendant",)),
    "metal click": ("click", ("metal",)),
    "heartbeat under a wool blanket": ("heartbeat", ("wool", "blanket")),
    "footsteps on gravel": ("footsteps", ("gravel",)),
}


def most(understood):
    return understood.effect or max(understood.material, key=understood.material.get)


@pytest.mark.parametrize(("text", "name"), NAMED.items())
def test_what_is_named_is_understood(text, name):
    assert most(understand(text, MATERIALS)) == name


@pytest.mark.parametrize("text", NOT_NAMED)
def test_what_is_not_named_is_refused_instead_of_invented(text):
    assert (understand(text, MATERIALS).effect, understand(text, MATERIALS).material) == ("", {})
    with pytest.raises(ParameterError, match="text must name a material or an effect that is known, e.g. "):
        material_in(text, MATERIALS)


@pytest.mark.parametrize(("text", "expected"), MIXED.items())
def test_what_is_not_understood_is_said(text, expected):
    understood = understand(text, MATERIALS)
    assert (most(understood), understood.unknown) == expected
    assert str(understood).endswith(f"; not understood: {', '.join(expected[1])}")


def test_a_list_is_a_mix_and_what_is_too_much_is_said():
    two = understand("sandpaper or cork", MATERIALS)
    assert (dict(two.material), two.unknown) == ({"sandpaper": 0.5, "cork": 0.5}, ())
    four = understand("brick, concrete, silk and cork", MATERIALS)
    assert len(four.material) == 3
    assert {*four.material, *four.unknown} == {"brick", "concrete", "silk", "cork"}


def test_a_kind_of_material_is_a_mix_of_those_of_the_kind():
    wood = understand("wood", MATERIALS).material
    assert wood.keys() == {"polished-wood", "rough-sawn-wood"}
    assert sum(wood.values()) == pytest.approx(1, abs=1e-3)


def test_materials_of_a_run_have_names_of_their_own():
    own = ["sand_paper", "Cotton-2", "tile"]
    assert understand("rough sandpaper", own).material == {"sand_paper": 1.0}
    assert understand("rain", [*own, "rain"]).material == {"rain": 1.0}
    assert understand("a tap", [*own, "a"]).effect == "tap"
    with pytest.raises(ParameterError, match="e.g. tile, got 'tyle'"):
        material_in("tyle", own)


def test_a_misspelt_name_gets_the_nearest():
    with pytest.raises(ParameterError, match="e.g. corduroy, got 'cordury'"):
        material_in("cordury", MATERIALS)
    with pytest.raises(ParameterError, match="e.g. heartbeat, got 'hartbeat'"):
        material_in("hartbeat", MATERIALS)


def test_a_material_cannot_be_made_of_an_effect():
    with pytest.raises(
        ParameterError, match="'heart beat' is an effect, no material; `tactogram effect heartbeat"
    ):
        material_in("heart beat", MATERIALS)
