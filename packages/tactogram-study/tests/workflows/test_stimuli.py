import json
import tomllib
from contextlib import closing

import numpy as np
import pytest
import tomli_w

from tactogram import workflows
from tactogram.cli import main
from tactogram.errors import DataError, ParameterError
from tactogram.rendering.level import parse_level
from tactogram.signal import Image, Signal
from tactogram.signal.io import write_image, write_signal
from tactogram_study.participants.sessions import SessionRegistry
from tactogram_study.session.store import SessionStore
from tactogram_study.study_file import Study
from tactogram_study.trials import PresentedStimulus
from tactogram_study.workflows.answers import open_answers
from tactogram_study.workflows.sessions import (
    log_played,
    simulate_study,
)
from tactogram_study.workflows.stimuli import StudyStimuli, stronger
from tactogram_study.workflows.studies import check_study


def test_check_refuses_a_display_that_a_session_refuses(study_file, tmp_path):
    changes = {"display": "voice-coil"}
    with pytest.raises(ParameterError, match="stimulus buzz: a browser plays parts of full scale") as checked:
        check_study(study_file, changes=changes)
    with closing(SessionRegistry(tmp_path)) as sessions, pytest.raises(ParameterError) as begun:
        sessions.begin(study_file, tmp_path / "session", changes=changes)
    assert str(begun.value) == str(checked.value)
    assert not (tmp_path / "session").exists()
    assert check_study(study_file, changes=changes | {"played_by": "server"})["display"] == "voice-coil"


def test_a_file_that_is_not_there_is_named(study_file, capsys):
    study_file.with_name("buzz.wav").unlink()
    assert main(["study", "check", str(study_file)]) == 1
    assert "stimulus buzz: " in capsys.readouterr().err


def test_what_is_played_is_rendered_at_the_staircases_level(study_file, tmp_path):
    study = Study.load(study_file)
    stimuli = StudyStimuli(study, tmp_path)
    [buzz] = study.all_stimuli
    plain, weaker = (stimuli.played(PresentedStimulus("A", buzz, gain)) for gain in (0.0, -20.0))
    ratio = np.abs(weaker.drive.signal.samples).max() / np.abs(plain.drive.signal.samples).max()
    assert ratio == pytest.approx(0.1, rel=1e-3)
    assert plain.sha256 == plain.drive.signal.sha256 != weaker.sha256
    assert stimuli.played(PresentedStimulus("B", None)).drive is None
    with SessionStore(tmp_path / "session", study) as store:
        code = store.enrol().code
        page = store.submit(code, "consent", {"consent": "agreed"}).page
        log_played(store, stimuli, code, page, "A")
        assert store.played_log(code)[0]["display"] in ("audio", study.display)


def test_a_level_that_replaces_the_signals_own_is_changed_itself():
    signal = Signal(np.ones(10), 100, "m/s^2")
    assert str(stronger(parse_level("sensation=20"), signal, -6.0)[0]) == "sensation=14"
    assert stronger(parse_level("peak=0.5"), signal, -20.0)[0].value == pytest.approx(0.05)
    assert stronger(parse_level("physical"), signal, 20.0)[1].samples.max() == pytest.approx(10)
    with pytest.raises(ParameterError, match="peak needs a share in 0 to 1"):
        stronger(parse_level("peak=0.5"), signal, 20.0)


def test_a_generated_stimulus_has_its_photograph_as_condition(tmp_path, monkeypatch):
    asked = []
    buzz = Signal(np.ones((1, 100), np.float32), 100.0, "m/s^2")
    monkeypatch.setattr(
        workflows, "generate", lambda run, condition, **more: asked.append(condition) or [buzz], raising=False
    )
    monkeypatch.setattr(workflows, "load_run", lambda run: run, raising=False)
    write_image(tmp_path / "cloth.png", Image(np.zeros((8, 8, 3), np.uint8)))
    made = {"simulated": "", "run": "run", "photograph": "../{item}.png"}
    study = Study.load(
        "reconstruction", changes={"grid.items": ["cloth"], "grid.by_condition.reconstructed": made}
    )
    (tmp_path / "study").mkdir()
    stimuli = StudyStimuli(study, tmp_path / "study", within=[tmp_path])
    assert stimuli.signal(study.all_stimuli[1]) is buzz
    assert asked[0]["image"].size == (8, 8)
    with pytest.raises(ParameterError, match="outside the study's folder"):
        StudyStimuli(study, tmp_path / "study", within=[tmp_path / "study"]).check_places()


def test_stimuli_are_generated_from_words_or_a_stroke_by_the_model_that_comes_trained(study_file, tmp_path):
    made = {"run": "texture_flow", "seconds": 2.0}
    changes = {
        "design": {"kind": "magnitude"},
        "stimuli": [
            {"name": "rough", "words": {"rough": 6.0}, "given": {"speed_mm_s": 150.0}, **made},
            {"name": "slow", "vibration": "buzz.wav", "given": {"vibration_speed_mm_s": 100.0}, **made},
        ],
    }
    study = Study.load(study_file, changes=changes)
    stimuli = StudyStimuli(study, tmp_path, within=[tmp_path])
    stimuli.check_places()
    rough, slow = map(stimuli.signal, study.all_stimuli)
    assert (rough.unit, rough.seconds, slow.seconds) == ("m/s^2", 2.0, 2.0)
    frequencies = np.fft.rfftfreq(len(slow), 1 / slow.rate)
    assert frequencies[np.abs(np.fft.rfft(slow.samples[0])).argmax()] == pytest.approx(80, abs=20)
    outside = Study.load(
        study_file, changes={**changes, "stimuli": [{**changes["stimuli"][1], "vibration": "../x.wav"}]}
    )
    with pytest.raises(ParameterError, match="outside the study's folder"):
        StudyStimuli(outside, tmp_path, within=[tmp_path]).check_places()


def test_friction_over_displacement_is_drawn_from_its_model_and_follows_the_finger(tmp_path):
    rng = np.random.default_rng(0)
    ripple = np.convolve(rng.standard_normal(4000), np.ones(8) / 8, "same")
    recorded = Signal(0.5 + 0.05 * ripple, 20.0, "1", ("along",), "displacement")
    write_signal(tmp_path / "linen.npz", recorded)
    changes = {
        "grid.items": ["linen"],
        "grid.source": {"file": "{item}.npz", "speed_mm_s": 50.0},
        "names": None,
    }
    study = Study.load("fabric-realism", changes=changes)
    stimuli = StudyStimuli(study, tmp_path)
    real, made = (stimuli.signal(each) for each in study.all_stimuli)
    assert (made.domain, made.rate, len(made)) == ("displacement", 20.0, 4000)
    assert made.samples.mean() == pytest.approx(0.5, abs=0.01)
    assert made.samples.std() == pytest.approx(real.samples.std(), rel=0.1)
    assert not np.array_equal(made.samples, real.samples)
    played = stimuli.played(PresentedStimulus("", study.all_stimuli[1]))
    assert played.stream.output.display.name == "electrovibration"
    assert played.stream.texture.along == "x"  # the same place feels the same


def test_answers_are_marked_where_file_or_run_of_a_stimulus_says_that_it_is_simulated(study_file, tmp_path):
    signal = Signal(np.ones(100), 1000, "m/s^2")
    write_signal(tmp_path / "made.wav", signal, metadata={"simulated": True})
    write_image(tmp_path / "made.png", Image(np.zeros((8, 8, 3), np.uint8)), metadata={"simulated": True})
    sources = {
        "felt": {"file": "made.wav"}, "seen": {"file": "buzz.wav", "image": "made.png"},
        "generated": {"run": "texture_flow"}, "recorded": {"file": "buzz.wav"},
    }  # fmt: skip
    changes = {
        "design": {"kind": "magnitude"},
        "stimuli": [{"name": name, **source} for name, source in sources.items()],
    }
    assert check_study(study_file, changes=changes)["simulated_stimuli"] == 3
    simulate_study(study_file, tmp_path / "session", participants=1, changes=changes)
    rows = open_answers(tmp_path / "session").where(design="magnitude")
    marked = {row.stimulus: row.more.get("simulated_stimuli") for row in rows}
    assert marked == {"felt": "true", "seen": "true", "generated": "true", "recorded": None}


def test_what_is_limited_of_a_stimulus_is_said_before_and_stored_with_the_answers(
    study_file, tmp_path, capsys
):
    limit = "speed 900 mm/s is outside of what was recorded: it counts as 399.7 mm/s"
    write_signal(tmp_path / "made.wav", Signal(np.ones(100), 1000, "m/s^2"), metadata={"limited": [limit]})
    cork = {"run": "texture_flow", "material": "cork", "seconds": 0.2}
    sources = {
        "fast": cork | {"given": {"speed_mm_s": 900.0}}, "usual": cork | {"given": {"speed_mm_s": 100.0}},
        "kept": {"file": "made.wav"}, "recorded": {"file": "buzz.wav"},
    }  # fmt: skip
    stimuli = [{"name": name, **source} for name, source in sources.items()]
    design = {"kind": "magnitude"}
    whole = tomllib.loads(study_file.read_text()) | {"design": design, "stimuli": stimuli}
    study_file.write_text(tomli_w.dumps(whole))
    assert check_study(study_file)["limited"] == {}  # nothing is made
    assert main(["study", "check", str(study_file), "--stimuli", "--json"]) == 0
    found = capsys.readouterr()
    assert json.loads(found.out)["limited"] == {"fast": [limit], "kept": [limit]}
    assert found.err == f"note: stimulus fast: {limit}\nnote: stimulus kept: {limit}\n"
    simulate_study(study_file, tmp_path / "session", participants=1)
    rows = open_answers(tmp_path / "session").where(design="magnitude")
    marked = {row.stimulus: row.more.get("limited_stimuli") for row in rows}
    assert marked == {
        "fast": f"fast: {limit}", "kept": f"kept: {limit}", "usual": None, "recorded": None,
    }  # fmt: skip


@pytest.mark.parametrize("given", [{"photograph": "away.png"}, {"vibration": "away.wav"}])
def test_a_study_is_not_checked_without_what_its_run_is_given(given):
    stimuli = [{"name": "a", "run": "r", **given}]
    with pytest.raises(DataError, match=r"stimulus a: .*away\.(png|wav): no such file"):
        check_study("abx", changes={"stimuli": stimuli})
