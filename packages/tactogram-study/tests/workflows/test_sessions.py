import pytest

from tactogram.errors import DataError
from tactogram_study.session.store import SessionStore
from tactogram_study.study_file import Study
from tactogram_study.workflows.answers import open_answers
from tactogram_study.workflows.sessions import (
    begin_session,
    effect_of,
    origin_folder,
    simulate_study,
)
from tactogram_study.workflows.studies import study_folder


def test_a_study_goes_from_check_to_export_and_withdrawal(study_file, tmp_path, printed, capsys):
    folder = tmp_path / "session"
    checked = printed("study", "check", study_file, "--stimuli")
    assert (checked["design"], checked["trials"]) == ("staircase", 4)
    assert list(checked["rendered"]) == ["buzz"]
    done = printed("study", "simulate", study_file, "--out", folder, "--participants", 2, "--play")
    assert done["simulated"] is True
    facts = printed("study", "export", folder, "--out", tmp_path / "a.csv", "--bids", tmp_path / "bids")
    assert facts["simulated_participants"] == 2
    assert (tmp_path / "bids" / "participants.tsv").is_file()
    answers = open_answers(tmp_path / "a.csv")
    trials = answers.where(design="staircase")
    assert len(trials) == 8
    # At 0 dB what was played is what `check --stimuli` rendered; silence is beside it.
    assert checked["rendered"]["buzz"] in trials.rows[0].played_sha256
    code = done["simulated_participants"][0]
    gone = printed("study", "withdraw", folder, code)
    assert gone == {"folder": str(folder), "answers_deleted": 5, "participants_left": 1}
    assert code not in open_answers(folder).column("participant")


def test_simulated_participants_are_kept_apart_from_people(study_file, tmp_path):
    with SessionStore(tmp_path / "session", Study.load(study_file)) as store:
        store.enrol()
    with pytest.raises(Exception, match="people took this study; give simulated participants another folder"):
        simulate_study(study_file, tmp_path / "session", participants=1)


def test_an_effect_is_given_by_name():
    effect = effect_of({"d_prime": 1.5, "shift.generated": -10})
    assert (effect.d_prime, effect.shift) == (1.5, {"generated": -10})


def test_a_session_knows_where_its_stimuli_lie(study_file, tmp_path):
    session = begin_session(study_file, tmp_path / "deep" / "session")
    assert origin_folder(session) == study_file.resolve().parent
    assert begin_session(study_file, session) == session
    assert origin_folder(begin_session("abx", tmp_path / "shipped")) == study_folder("abx")
    assert origin_folder(tmp_path) == tmp_path
    (session / "origin.json").write_text("[]")
    with pytest.raises(DataError, match=r"origin\.json: lacks the study"):
        origin_folder(session)


def test_a_session_is_not_begun_with_stimuli_that_are_missing(study_file, tmp_path):
    next(study_file.parent.glob("**/*.wav")).unlink()
    with pytest.raises(DataError, match="no such file"):
        begin_session(study_file, tmp_path / "session")
    assert not (tmp_path / "session").exists()
