import numpy as np
import pytest

import tactogram_capture.workflows.live
from tactogram.errors import DataError, ParameterError
from tactogram_capture.live.recognition import Classification, WindowClassification
from tactogram_capture.session.console import CaptureStatus
from tactogram_capture.workflows.session import capture
from tactogram_studio.pages.live.choices import (
    confine_address,
    plan_choices,
    session_state,
    source_choices,
    without_materials,
)
from tactogram_studio.pages.live.console import PageConsole, PageMetronome
from tactogram_studio.pages.live.runner import LiveRequest, LiveRunner
from tactogram_studio.pages.live.traces import Traces
from tactogram_studio.workspace.folder import Workspace

SIMULATED = "simulated:twelite?rate=330&loss=0.02"


def test_traces_hold_the_extremes_of_each_bin():
    x = np.random.default_rng(0).standard_normal((2, 1000)).astype(np.float32)
    traces = Traces()
    for start in range(0, 1000, 37):
        traces.add(x[:, start : start + 37], 1000.0)
    found = traces.since(0)
    assert (found["from"], found["next"], found["bin_s"]) == (0, 100, 0.01)
    assert found["low"] == pytest.approx(x.reshape(2, 100, 10).min(axis=2), rel=1e-3)
    assert found["high"] == pytest.approx(x.reshape(2, 100, 10).max(axis=2), rel=1e-3)


def test_a_page_gets_only_what_it_has_not_drawn_and_only_what_is_kept():
    traces = Traces(kept_s=0.5)
    traces.add(np.zeros((1, 1000), np.float32), 1000.0)
    assert (traces.since(90)["from"], len(traces.since(90)["lost"])) == (90, 10)
    assert (traces.since(0)["from"], len(traces.since(0)["lost"])) == (50, 50)
    assert traces.since(10_000)["from"] == 50  # of another source, before a restart


def test_lost_samples_are_marked_and_a_lost_bin_is_empty():
    x = np.ones((1, 30), np.float32)
    x[0, 5], x[0, 10:20] = np.nan, np.nan
    traces = Traces()
    traces.add(x, 1000.0)
    found = traces.since(0)
    assert found["lost"] == [1, 1, 0]
    assert found["low"] == [[1.0, None, 1.0]]


def test_samples_wait_for_the_rate():
    traces = Traces()
    traces.add(np.zeros((3, 50), np.float32), None)
    assert traces.since(0)["next"] == 0
    traces.add(np.zeros((3, 50), np.float32), 100.0)
    assert traces.since(0)["next"] == 100


def test_an_answer_counts_once_and_only_for_its_question():
    console = PageConsole()
    tried = []

    def idle():
        number = console.question.number
        tried.extend(
            [
                console.answer(number - 1, "a"),
                console.answer(number, "x"),
                console.answer(number, "r"),
                console.answer(number, "a"),
            ]
        )

    assert console.ask("Good?", {"a": "accept", "r": "redo"}, default="a", idle=idle) == "r"
    assert tried == [False, False, True, False]
    assert console.question is None


def test_an_ended_console_answers_with_a_stop():
    console = PageConsole()
    console.show(CaptureStatus("take 1", "countdown", ""))
    console.end()
    assert console.ask("Begin?", {"b": "begin", "q": "stop"}, default="b", idle=lambda: None) == "q"


def test_the_metronome_says_where_its_beat_is():
    now = [10.0]
    metronome = PageMetronome(lambda: now[0])
    assert metronome.facts() is None
    metronome.start(0.8, 3.0, back_and_forth=True)
    now[0] = 11.0
    assert metronome.facts() == {"number": 1, "elapsed_s": 1.0, "interval_s": 0.8, "back_and_forth": True}
    now[0] = 14.0
    assert metronome.facts() is None


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


def test_simulated_sources_are_always_there(surfaces):
    workspace = Workspace.at(surfaces)
    missing = {
        "kind": "lsl",
        "address": None,
        "what": "Lab Streaming Layer stream",
        "missing": "install pylsl",
    }
    found = source_choices(workspace, [missing])
    assert (found[0].address, found[0].missing) == (None, "install pylsl")
    addresses = [choice.address for choice in found if choice.simulated]
    assert "played:studio/first/surfaces?rate=330&loss=0.01&materials=all" in addresses
    assert any(address.startswith("simulated:twelite") for address in addresses)
    assert without_materials(addresses[0]) == "played:studio/first/surfaces?rate=330&loss=0.01"


@pytest.mark.parametrize(
    "address",
    [
        "played:../store",
        "log:/etc/passwd",
        "twelite:/dev/x?log=/tmp/raw.log",
        "simulated:twelite?rate=330&file=..%2Fx.npz",
    ],
)
def test_a_source_reads_and_writes_nothing_outside_of_the_workspace(tmp_path, address):
    with pytest.raises(ParameterError, match="outside"):
        confine_address(Workspace.at(tmp_path), address)


def test_a_confined_address_stays_what_it_is(tmp_path):
    workspace = Workspace.at(tmp_path)
    assert confine_address(workspace, "serial:/dev/ttyACM0?unit=g") == "serial:/dev/ttyACM0?unit=g"
    assert confine_address(workspace, "played:s?loss=0.1") == f"played:{tmp_path / 's'}?loss=0.1"


@pytest.mark.parametrize("text", ["{", "[]", '{"source": "a", "other": 1}', "\xff"])
def test_a_damaged_request_or_journal_is_none(tmp_path, text):
    (tmp_path / "live.json").write_bytes(text.encode("latin-1"))
    assert LiveRunner(tmp_path).last_request() is None
    journal = tmp_path / "rec.sessions" / "one" / "session.jsonl"
    journal.parent.mkdir(parents=True)
    journal.write_bytes(text.encode("latin-1") + b"\n")
    assert session_state(Workspace.at(tmp_path), "rec", "one") is None


def test_plans_of_the_workspace_are_found(tmp_path, plan):
    workspace = Workspace.at(tmp_path)
    assert plan_choices(workspace)["tiny.toml"] == "tiny.toml: Tiny"
    assert "first-try" in plan_choices(workspace)


def test_a_session_that_is_none_has_no_state(tmp_path):
    workspace = Workspace.at(tmp_path)
    assert session_state(workspace, "rec", "none") is None
    with pytest.raises((ParameterError, DataError)):
        session_state(workspace, "../rec", "none")


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
