import numpy as np
import pytest

from tactogram_capture.session.console import CaptureStatus
from tactogram_studio.tasks.live_console import PageConsole, PageMetronome, Traces


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
