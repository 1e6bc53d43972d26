import pytest

from tactogram.errors import ParameterError
from tactogram_study.analysis.findings import AnalysisSection, Finding
from tactogram_study.session.progress import next_page
from tactogram_study.simulated_participants import simulated_answers
from tactogram_study.study_file import Study, shipped_studies
from tactogram_study.trials import PageAnswers, Participant
from tactogram_study.workflows.analysis import named_answers, named_section


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


def test_what_is_read_has_names_and_whole_words_only():
    names = {"tile": "floor tile", "cork-sheet": "cork sheet", "generated": "made"}
    table = [{"texture": "tile", "generated mean": 2.0, "verdict": "tile"}]
    found = Finding("tile over tile-2", "t", "check", "generated minus recorded, mm", 1.0)
    section = AnalysisSection("Which?", "two_area", "which", 2, 4, True, (found,), {"per texture": table})
    named = named_section(section, names)
    assert named.findings[0].of == "floor tile over tile-2"
    assert named.findings[0].measure == "made minus recorded, mm"
    assert list(named.tables.values()) == [[{"texture": "floor tile", "made mean": 2.0, "verdict": "tile"}]]
    assert named_section(section, {}) is section
    answers = simulated_answers(Study.load("threshold", changes={"design.most_trials": 4}), 1)
    assert "floor tile" in named_answers(answers, names).unique("condition")


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
