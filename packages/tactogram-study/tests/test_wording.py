import pytest
from pydantic import ValidationError

from tactogram_study.wording import Wording


def test_a_plain_string_stands_for_every_language():
    plain = Wording("Hello")
    assert plain.in_language("zh") == plain.in_language("pt-BR") == plain.in_english() == "Hello"
    assert plain.languages == ()


def test_a_text_stands_for_the_regions_of_its_language_only():
    text = Wording({"en": "rough", "de": "rau", "pt-BR": "áspero"})
    assert text.in_language("de-AT") == "rau"
    assert (text.in_language("pt"), text.in_language("fr")) == ("", "")
    assert text.languages == ("en", "de", "pt-BR")
    assert not Wording(en="")


def test_values_are_filled_in_in_the_same_language():
    said = Wording(de="Berühren Sie {item} {n}.", en="Touch {item} {n}.").filled(
        item=Wording(de="Kork", en="cork"), n="2"
    )
    assert said == Wording(de="Berühren Sie Kork 2.", en="Touch cork 2.")
    assert Wording("Touch {item}.").filled(item=Wording(de="Kork")).in_language("de") == "Touch Kork."


def test_a_text_comes_back_from_its_values():
    for text in (Wording("A"), Wording(ja="あ", en="A"), Wording()):
        assert Wording.model_validate(text.model_dump()) == text


@pytest.mark.parametrize("key", ["", "English", "d", "de_DE", "DE"])
def test_a_language_must_be_a_tag(key):
    with pytest.raises(ValidationError, match="must be a tag such as en, de or pt-BR"):
        Wording({key: "text"})
