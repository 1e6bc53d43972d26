import re
from pathlib import Path

import pytest
from pydantic import ValidationError

from tactogram.datasets.ratings.words import JAPANESE
from tactogram.errors import ParameterError
from tactogram_study.session.progress import next_page
from tactogram_study.trials import Participant
from tactogram_study.wording import (
    Wording,
    complete_texts,
    default_text,
    language_texts,
    missing_texts,
    own_name,
)


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


STATIC = Path(__file__).parents[1] / "src/tactogram_study/participants/static"


@pytest.fixture
def own(tmp_path, monkeypatch):
    monkeypatch.setenv("TACTOGRAM_LANGUAGES", str(tmp_path))

    def write(text, name="nl.toml"):
        (tmp_path / name).write_text(text, encoding="utf-8")

    return write


@pytest.mark.parametrize("language", ["en", "ja", "de", "fr", "es", "zh"])
def test_a_shipped_language_has_every_text(language):
    assert missing_texts(language) == ()
    texts = language_texts()[language]
    same = [key for key in texts if texts[key] == language_texts()["en"][key]]
    assert language == "en" or set(same) <= {"comma", "code", "questions", "trial"}


def test_the_japanese_words_are_those_of_the_papers():
    texts = language_texts()["ja"]
    assert {word: texts[f"word_{word}"] for word in JAPANESE} == JAPANESE


def test_every_text_that_a_page_shows_is_in_the_files():
    script = "".join(path.read_text(encoding="utf-8") for path in STATIC.glob("*.js"))
    shown = set(re.findall(r'say\(\w+(?:\(\))?, "(\w+)"', script))
    shown |= set(re.findall(r'\d+: "(\w+)"', script))  # by the status of a refusal
    shown |= {key for keys in re.findall(r'\? "(\w+)" : "(\w+)"\)', script) for key in keys}
    assert len(shown) > 50
    assert shown <= set(language_texts()["en"])


def test_a_file_of_ones_own_adds_a_language_and_lacks_what_it_does_not_have(own):
    own('name = "Nederlands"\nabx_which = "Is X A of B?"\nneed_play = "Speel eerst {names} af."')
    assert own_name("nl") == own_name("nl-BE") == "Nederlands"
    assert complete_texts("nl")["need_play"] == "Speel eerst {names} af."
    assert complete_texts("nl")["next"] == "Next"
    assert "next" in missing_texts("nl")
    assert "need_play" not in missing_texts("nl-BE")
    assert default_text("abx_which").in_language("nl") == "Is X A of B?"
    assert default_text("abx_instructions").in_language("nl") == language_texts()["en"]["abx_instructions"]


def test_a_file_of_ones_own_changes_single_texts_of_a_shipped_language(own):
    own('next = "Nächste Seite"', "de.toml")
    assert complete_texts("de")["next"] == "Nächste Seite"
    assert complete_texts("de")["begin"] == "Neu beginnen"
    assert missing_texts("de") == ()


def test_a_study_can_be_in_a_language_of_ones_own(own, make_study):
    own('consent_agreed = "Ja, ik doe mee"')
    study = make_study(title={"nl": "Proef"}, consent={"nl": "Doet u mee?"})
    page = next_page(study, Participant("K1", 1, "nl"), []).shown("nl")
    assert page["text"] == "Doet u mee?"
    assert [option["text"] for option in page["questions"][0]["options"]] == [
        "Ja, ik doe mee",
        "I do not agree",
    ]


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        (
            "nl.toml",
            'nxt = "Verder"',
            r"nl\.toml: unknown key 'nxt'; the keys are those of `study languages en`",
        ),
        ("nl.toml", "next = 3", r"nl\.toml: next must be a text, got 3"),
        ("nl.toml", 'need_play = "Speel {name} af."', r"need_play must contain \{names\}, got \{name\}"),
        ("nl.toml", 'next = "{x}"', r"next must contain nothing in braces, got \{x\}"),
        (
            "dutch_1.toml",
            'next = "Verder"',
            r"dutch_1\.toml: must be named after a language tag, as nl\.toml",
        ),
        ("nl.json", "{}", "must be a language file such as nl.toml or a folder of such files, found none"),
    ],
)
def test_a_wrong_language_file_is_refused_in_one_line(own, make_study, name, text, said):
    own(text, name)
    with pytest.raises(ParameterError, match=said):
        make_study()
