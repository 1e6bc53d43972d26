"""The capture experiment's own arithmetic: its plan, and how long a name takes after a change of surface."""

import pytest
from benchmarks.experiments import capture_session as experiment

from tactogram_capture.live.recognition import Classification, WindowClassification
from tactogram_capture.session.plan import SessionPlan


def guess(time_s, name):
    heard = Classification({"carpet2": float(name == "carpet2"), "sponge-g": float(name == "sponge-g")})
    return WindowClassification(0, time_s, heard, 0.0, 1.0, 0.01, 0)


def test_its_plan_is_one(tmp_path):
    path = tmp_path / "plan.toml"
    path.write_text(experiment.PLAN.format(materials=list(experiment.KNOWN), repetitions=2, seconds=3.0))
    plan = SessionPlan.load(path)
    assert len(plan.trials()) == 10
    assert (plan.speeds_mm_s, plan.rate) == ((experiment.SPEED_MM_S,), 330.0)


def test_the_delay_is_from_the_change_to_the_first_right_name():
    found = [guess(0.5, "carpet2"), guess(1.0, "carpet2"), guess(4.2, "carpet2"), guess(4.7, "sponge-g")]
    delays = experiment._delays(found, ["carpet2", "carpet2", "sponge-g", "sponge-g"])
    assert delays == {"carpet2": pytest.approx(0.5), "sponge-g": pytest.approx(0.7)}
    assert experiment._delays([guess(4.2, "carpet2")], ["sponge-g"]) == {"sponge-g": None}
