import json
import re
import tomllib
from pathlib import Path

import pytest

from tactogram.datasets import WORDS
from tactogram.errors import DataError, ParameterError
from tactogram_simulate.materials import STROKING_9
from tactogram_study.designs import designs
from tactogram_study.session.progress import consent_sha256, next_page
from tactogram_study.simulated_participants import simulated_answers
from tactogram_study.study_file import Study, shipped_studies
from tactogram_study.trials import PageAnswers, Participant
from tactogram_study.wording import wordings
from tactogram_study.workflows.studies import planned_minutes


@pytest.mark.parametrize("name", shipped_studies())
def test_a_shipped_study_has_each_language_and_comes_back_from_its_values(name):
    study = Study.load(name)
    assert study.languages == ("en", "ja", "de", "fr", "es", "zh")
    for place, wording in wordings(study):
        assert not wording or set(study.languages) <= set(wording.languages), place
    assert study.consent
    assert Study.of(json.loads(study.as_json())).sha256 == study.sha256
    assert all(stimulus.is_simulated or stimulus.text for stimulus in study.all_stimuli)


def test_the_two_area_study_has_the_numbers_of_saga_et_al():
    """Sec. IV-A: a target of "500 mm/s", "a 100 mm long Visual Analog Scale", "Ten trials … for each texture"."""
    study = Study.load("two-area")
    assert {stimulus.item for stimulus in study.all_stimuli} == {surface.name for surface in STROKING_9}
    assert {stimulus.condition for stimulus in study.all_stimuli} == {"recorded", "generated"}
    design = study.design
    assert (design.speed_mm_s, design.vas_mm, design.repeats, study.trials) == (500, 100, 10, 90)
    assert (design.asked_for, design.realism, design.sides) == ("generated", True, "random")
    assert {question.id for question in study.after} == {"told_apart", "comment"}


def test_a_person_takes_about_as_long_as_stated_in_the_two_area_study():
    """Saga et al., Sec. IV-A: "It took about one hour to complete the experiment"; ten people took part."""
    assert planned_minutes(Study.load("two-area")) == pytest.approx(60, rel=0.15)
    table = designs()["two_area"].power["two_area"]
    assert 10 in table.participants
    assert Study.load("two-area").trials in table.trials


@pytest.mark.parametrize(
    ("name", "conditions", "trials"),
    [
        ("plate-words", {""}, 12),
        ("display-words", {"sensor", "A", "B", "C", "D"}, 60),
        ("image-words", {"1", "1000", "5000", "10000"}, 48),
    ],
)
def test_studies_of_words_have_the_numbers_of_hatori_et_al(name, conditions, trials):
    """2023, Sec. III-A: ten words "on a 7-point unipolar scale", random order; 2025, Sec. II-D: "48 conditions"."""
    study = Study.load(name)
    assert {stimulus.condition for stimulus in study.all_stimuli} == conditions
    assert (study.trials, study.order) == (trials, "random")
    assert {stimulus.item for stimulus in study.all_stimuli} == {f"plate{n:02d}" for n in range(1, 13)}
    assert (study.design.words, study.design.low, study.design.high) == (WORDS, 1, 7)
    assert study.design.image_mm == 30  # 2025, Sec. II-D: "30 mm square"


def test_the_study_of_evoked_words_has_the_numbers_of_hatori_et_al():
    """2025, Sec. II-B: "320 images were divided into four sets, each containing 80 images", in random order."""
    study = Study.load("evoked-words")
    assert (len(study.all_stimuli), study.design.set_size, study.trials, study.order) == (
        320,
        80,
        80,
        "random",
    )
    assert study.design.words == WORDS
    asked = study.design.word_question("rough", study.all_stimuli[0])
    assert asked.values == {"evoked": 1, "not evoked": 0}
    assert [option.value for option in asked.question.options] == ["evoked", "not evoked"]


@pytest.mark.parametrize(
    ("name", "paper"), [("reconstruction", "Neshov, .*Sec. 5"), ("fabric-realism", "Cai, .*Sec. 5")]
)
def test_what_the_papers_leave_to_a_future_study_is_one(name, paper):
    """Neshov et al.: "A dedicated user study would be necessary"; Cai et al.: "subjective ratings on the realness"."""
    study = Study.load(name)
    assert re.match(paper, study.source)
    assert "not carried out" in study.source
    assert study.design.realism


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"colour": "red"}, "unknown key 'colour'; known here: after"),
        (
            {"design": {"kind": "abx", "times": 3}},
            "study: design: unknown key 'times'; known here: instructions",
        ),
        (
            {"design": {"kind": "guess"}},
            "design.kind must be one of abx, .* TACTOGRAM_DESIGNS names, got 'guess'",
        ),
        ({"design": {"kind": "abx", "repeats": 0}}, "repeats: must be greater than or equal to 1, got 0"),
        ({"order": "any"}, "order: must be 'random', 'blocks'"),
        ({"name": "My study"}, "name: String should match"),
        (
            {"title": {"en": "only English"}, "languages": ["ja", "en"]},
            "title lacks the language ja; give title.ja",
        ),
        (
            {"title": {"de": "Titel"}, "consent": {"fr": "D'accord"}},
            "title lacks the language fr; give title.fr",
        ),
        ({"names": {"a": {"French": "un"}}}, "names.a: a text's language must be a tag .* got 'French'"),
        ({"languages": ["de", "de"]}, "languages must differ"),
        ({"languages": ["German"]}, "languages.0: String should match pattern"),
        ({"stimuli": []}, "needs stimuli"),
        ({"stimuli": [{"name": "a", "file": "a.wav", "run": "runs/b"}]}, "one source, got file and run"),
        ({"stimuli": [{"name": "a"}, {"name": "a"}]}, "names of stimuli must differ, got 'a' twice"),
        (
            {"grid": {"items": ["a"], "by_condition": {"x": {}}}},
            "by_condition names x, which is no condition",
        ),
        ({"grid": {"items": ["a"], "by_condition": {"": {"sound": "x"}}}}, "by_condition.: sound: Extra"),
        (
            {"design": {"kind": "two_area", "asked_for": "made"}},
            "needs each item as 'made' and as 'recorded'",
        ),
        ({"design": {"kind": "staircase", "start_db": 90.0}}, "lowest_db <= start_db <= highest_db"),
        ({"design": {"kind": "magnitude", "standard": "x"}}, "standard must be one of cork-recorded"),
        ({"design": {"kind": "rating", "words": ["sand paper"]}}, "words: a word must be letters, digits"),
        ({"design": {"kind": "evoked", "sets": 2}}, "sets must be at most 1"),
        ({"before": [{"id": "a", "text": "?", "kind": "choice"}]}, "needs at least two different options"),
        ({"before": [{"id": "a", "text": "?", "kind": "vas"}]}, "vas needs low < high"),
    ],
)
def test_what_is_wrong_with_a_study_is_said_in_one_line(make_study, changes, message):
    with pytest.raises(ParameterError, match=message) as refused:
        make_study(**changes)
    assert "\n" not in str(refused.value)


def test_a_file_that_is_none_is_refused(tmp_path):
    with pytest.raises(ParameterError, match="no such study; shipped ones are abx"):
        Study.load(tmp_path / "x.toml")
    (tmp_path / "x.toml").write_text("title = ")
    with pytest.raises(DataError, match="x.toml: not readable as TOML"):
        Study.load(tmp_path / "x.toml")


def test_values_of_a_shipped_study_can_be_changed():
    assert Study.load("two-area", changes={"design.repeats": 2, "seed": 5}).trials == 18


def test_the_study_in_the_documentation_is_one():
    text = (Path(__file__).parents[3] / "docs" / "study-files.md").read_text(encoding="utf-8")
    study = Study.of(tomllib.loads(text.partition("```toml\n")[2].partition("```")[0]))
    assert [stimulus.name for stimulus in study.all_stimuli][:2] == ["cork/recorded", "cork/generated"]
    assert study.all_stimuli[1].run == "runs/my-run"


def test_a_study_of_an_earlier_session_keeps_its_values_and_hash():
    facts = (Path(__file__).parent / "golden/study-of-ja-and-en.json").read_text(encoding="utf-8")
    study = Study.of(json.loads(facts))
    assert study.as_json() == facts
    assert (
        consent_sha256(study) == "891b7c60bdd9e1a2e71005637cca0f844ac1ec5335e4b5dec3e75780d076ef0c"
    )  # stored with the answers of then


@pytest.mark.parametrize(
    ("texts", "languages"),
    [
        ({}, ("en", "ja")),
        ({"title": {"de": "Titel", "fr": "Titre"}, "consent": {"fr": "Oui", "de": "Ja"}}, ("de", "fr")),
        ({"title": {"pt-BR": "Título"}}, ("pt-BR",)),
        ({"title": {"ja": "題", "en": "Title", "de": "Titel"}, "languages": ["de"]}, ("de",)),
    ],
)
def test_a_study_has_the_languages_of_its_texts(make_study, texts, languages):
    study = make_study(**texts)
    assert study.languages == languages
    assert list(json.loads(study.as_json())["title"]) == sorted(languages)


def first_trial(study, language="ja"):
    participant = Participant("K1", 1, language)
    given = [PageAnswers("consent", {"consent": "agreed"})]
    return next_page(study, participant, given).shown(language)


@pytest.mark.parametrize(("language", "said"), [("ja", "金属板"), ("en", "Touch plate ")])
def test_a_page_calls_things_as_the_file_says_in_its_language(language, said):
    [slot] = first_trial(Study.load("plate-words"), language)["slots"]
    assert said in slot["text"]
    assert "plate0" not in slot["text"]


def test_the_page_after_two_areas_calls_the_texture_by_its_name():
    study = Study.load("two-area", changes={"grid.items": ["cork-sheet"], "design.repeats": 1, "before": []})
    participant = Participant("K1", 1, "ja")
    given = [PageAnswers("consent", {"consent": "agreed"})]
    page = next_page(study, participant, given)
    given.append(PageAnswers(page.token, {"which": "A"}, page.more))
    text = next_page(study, participant, given).shown("ja")["text"]
    assert "コルクシート" in text
    assert "cork-sheet" not in text
    assert "carpet" in study.unused_names


def test_rows_keep_the_keys():
    study = Study.load("plate-words", changes={"grid.count": 2, "design.words": ["rough"]})
    trials = simulated_answers(study, 1).where(design="rating")
    assert set(trials.column("stimulus")) == {"plate01", "plate02"}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"names.tile": {"ja": "タイル"}}, "names.tile lacks the language en"),
        ({"names.tile": "carpet"}, "two are called 'carpet' in en"),
    ],
)
def test_names_must_differ_and_be_there_in_each_language(changes, said):
    with pytest.raises(ParameterError, match=said):
        Study.load("threshold", changes=changes)


@pytest.mark.parametrize("name", [name for name in shipped_studies() if name != "magnitude"])
def test_what_is_shipped_has_names_for_all_its_items_in_each_language(name):
    study = Study.load(name)
    assert not study.unused_names
    for language in study.languages:
        assert {one.item for one in study.all_stimuli} <= set(study.names_in(language))
