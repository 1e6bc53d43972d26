import pytest

import tactogram_capture.workflows.live
from tactogram.errors import ParameterError
from tactogram_capture.live.recognition import Classification, WindowClassification
from tactogram_capture.workflows.session import capture
from tactogram_studio.pages.live.form import (
    session_state,
)
from tactogram_studio.tasks.live import LiveRequest, LiveRunner
from tactogram_studio.workspace.folder import Workspace

SIMULATED = "simulated:twelite?rate=330&loss=0.02"


def test_a_runner_listens_draws_and_lets_the_device_go(tmp_path, until):
    runner = LiveRunner(tmp_path)
    runner.start(LiveRequest(SIMULATED))
    until(lambda: runner.now()["traces"]["next"] > 40)
    now = runner.now()
    assert (now["state"], now["axes"], now["simulated"]) == ("watching", ["x", "y", "z"], True)
    assert now["levels"]["rms"] > 0
    with pytest.raises(ParameterError, match="stop it first"):
        runner.start(LiveRequest(SIMULATED))
    runner.stop()
    assert not runner.running
    assert runner.result["simulated"]
    assert runner.last_request() == LiveRequest(SIMULATED)


@pytest.mark.parametrize("address", ["nothing:", "simulated:twelite?rate=fast"])
def test_what_is_no_address_begins_nothing(tmp_path, address):
    runner = LiveRunner(tmp_path)
    with pytest.raises(ParameterError):
        runner.start(LiveRequest(address))
    assert (runner.state, runner.last_request()) == ("idle", None)


def test_a_device_that_does_not_open_is_told(tmp_path, until):
    runner = LiveRunner(tmp_path)
    runner.start(LiveRequest("serial:/dev/no-such-port"))
    until(lambda: not runner.running)
    assert "no-such-port" in runner.error
    assert runner.state == "idle"


@pytest.fixture(name="plan")
def plan_fixture(tmp_path):
    """Give a plan of two short takes."""
    path = tmp_path / "tiny.toml"
    path.write_text(
        'title = "Tiny"\nmaterials = ["one", "two"]\nseconds = 0.3\ncountdown_s = 0\norder = "as-listed"\nrate = 330\n'
        "[limits]\nmost_lost = 1.0\nlongest_gap_s = 5.0\n"
    )
    return path


def test_a_session_is_the_terminals_and_says_how_far_it_is(tmp_path, plan, until):
    workspace = Workspace.at(tmp_path)
    runner = LiveRunner(workspace.studio_folder)
    request = LiveRequest(SIMULATED, plan=str(plan), data=str(tmp_path / "rec"), changes={"subject": "K7"})
    runner.start(request)
    for key in ("b", "a"):
        until(lambda k=key: runner.console.question is not None and k in runner.console.question.keys)
        assert runner.console.answer(runner.console.question.number, key)
    until(lambda: runner.console.question is not None and "b" in runner.console.question.keys)
    runner.stop()
    assert (runner.result["session"], runner.result["accepted"], runner.result["left"]) == ("tiny-K7", 1, 1)
    state = session_state(workspace, "rec", request.session_name)
    assert state == {"total": 2, "accepted": 1, "skipped": 0, "left": 1, "open": False}
    rest = capture(
        plan, source=SIMULATED, data=tmp_path / "rec", changes={"subject": "K7"}, yes=True, silent=True
    )
    assert (rest["accepted"], rest["left"], rest["recordings"]) == (1, 0, 2)


def test_a_session_needs_a_plan_that_is_one_and_a_store(tmp_path, plan):
    runner = LiveRunner(tmp_path / "own")
    with pytest.raises(ParameterError, match="needs a store"):
        runner.start(LiveRequest(SIMULATED, plan=str(plan)))
    with pytest.raises(ParameterError, match="no such session plan"):
        runner.start(LiveRequest(SIMULATED, plan="none such", data=str(tmp_path / "rec")))


@pytest.mark.parametrize("text", ["{", "[]", '{"source": "a", "other": 1}', "\xff"])
def test_a_damaged_request_or_journal_is_none(tmp_path, text):
    (tmp_path / "live.json").write_bytes(text.encode("latin-1"))
    assert LiveRunner(tmp_path).last_request() is None
    journal = tmp_path / "rec.sessions" / "one" / "session.jsonl"
    journal.parent.mkdir(parents=True)
    journal.write_bytes(text.encode("latin-1") + b"\n")
    assert session_state(Workspace.at(tmp_path), "rec", "one") is None


def test_what_a_classifier_makes_of_it_is_shown(tmp_path, monkeypatch, until):
    guess = WindowClassification(
        100, 0.3, Classification({"cork": 0.2, "tile": 0.8}, none_of_these=True), 0.0, 1.5, 0.02, 0
    )

    def live(run, *, source, on_window, **rest):
        on_window(guess)
        return {"windows": 1, "judged": 1}

    monkeypatch.setattr(tactogram_capture.workflows.live, "live", live)
    runner = LiveRunner(tmp_path)
    runner.start(LiveRequest(SIMULATED, run="runs/nine"))
    until(lambda: runner.result is not None)
    shown = runner.now()["guess"]
    assert (shown["material"], shown["none_of_these"], shown["latency_s"]) == ("tile", True, 0.02)
    assert shown["probabilities"] == {"cork": 0.2, "tile": 0.8}
