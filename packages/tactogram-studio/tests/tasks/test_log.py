"""What the log and folder of a task say: progress, curves, time left and why it ended."""

import json

import pytest

from tactogram_studio.tasks.log import (
    TaskProgress,
    last_message,
    loss_curves,
    progress_of,
    reports_stop,
    thinned,
    time_left,
)

LOG = """prepare: 1/18
prepare: 18/18
standardise: 1/1 scale 0.3
classify: 1/500 loss 3.2
classify: 50/500 loss 2
"""


def test_progress_comes_from_log_and_metrics(tmp_path):
    assert progress_of("") is None
    assert progress_of(LOG) == TaskProgress("classify", 50, 500)
    lines = [{"stage": 1, "step": step, "loss": 1.0} for step in (10, 70)]
    (tmp_path / "metrics.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines) + '{"sta')
    assert progress_of(LOG, tmp_path) == TaskProgress("classify", 70, 500)
    (tmp_path / "metrics.jsonl").write_text('{"stage": 0, "step": 400}\n')  # of the stage before
    assert progress_of(LOG, tmp_path) == TaskProgress("classify", 50, 500)
    assert progress_of(LOG).share == pytest.approx(0.1)


def test_the_last_message_says_why_a_process_ended():
    assert last_message(LOG) is None
    assert last_message(LOG + "tactogram: training diverged at step 3\n") == "training diverged at step 3"
    assert last_message("Traceback (most recent call last):\n  File x\nKeyError: 'a'\n") == "KeyError: 'a'"
    assert reports_stop("stopped after step 4 of 9 of gan; all of it is in runs/on")
    assert reports_stop("interrupted")
    assert not reports_stop("training diverged")


def test_only_stages_of_several_steps_have_curves():
    lines = [{"stage": 0, "step": 1, "scale": 2.0}]
    lines += [{"stage": 1, "step": step, "loss": step / 2} for step in (1, 10, 20)]
    assert loss_curves(lines) == {"loss": [(1, 0.5), (10, 5.0), (20, 10.0)]}
    lines += [{"stage": 2, "step": step, "loss": 1.0} for step in (1, 2)]
    assert set(loss_curves(lines)) == {"loss (stage 1)", "loss (stage 2)"}
    means = [(1, 0.5), (3, 2.5), (5, 4.5), (7, 6.5), (9, 8.5)]
    assert thinned([(n, float(n)) for n in range(10)], most=5) == means


def test_time_left_follows_from_readings_of_the_stage():
    readings = [
        (0.0, TaskProgress("fit", 1, 1)),
        (1.0, TaskProgress("train", 10, 100)),
        (3.0, TaskProgress("train", 30, 100)),
    ]
    assert time_left(TaskProgress("train", 30, 100), readings) == (10.0, 7.0)
    assert time_left(TaskProgress("train", 30, 100), readings[:2]) is None
