"""Signals as they are felt, and the classifier that judges them."""

import numpy as np
import pytest

from tactogram.model import SignalKind
from tactogram.signal import Signal
from tactogram.workflows.evaluation.reference_models import (
    EVALUATION_SPEED_MM_S,
    FELT_RATE,
    EvaluationSettings,
    felt,
    kind_in_time,
    tactile_kind,
)


def test_a_signal_over_displacement_is_felt_at_one_speed():
    friction = Signal(np.sin(np.arange(400) / 5)[None], 40.0, "1", ("mu",), "displacement")
    met = felt(friction)
    assert (met.domain, met.rate, len(met)) == ("time", 40 * EVALUATION_SPEED_MM_S, 400)
    kind = SignalKind(40.0, "1", ("mu",), domain="displacement")
    assert (kind_in_time(kind).rate, kind_in_time(kind).domain) == (met.rate, "time")
    assert kind_in_time(kind_in_time(kind)) == kind_in_time(kind)


def test_what_no_finger_feels_is_left_out():
    sound = Signal(np.random.default_rng(0).standard_normal((1, 44_100)), 44_100.0, "1")
    assert felt(sound).rate == tactile_kind(SignalKind(44_100.0, "1", ("z",))).rate == FELT_RATE
    slow = Signal(np.ones((1, 100)), 330.0, "m/s^2")
    assert felt(slow) is slow


def test_a_window_is_no_longer_than_the_shortest_recording():
    settings = EvaluationSettings(steps=7)
    assert settings.classifier_config(1000.0, 40)["window"] == 40
    config = settings.classifier_config(1000.0, 10**6)
    assert config["window"] == pytest.approx(1000 * settings.window_s, abs=1)
    assert config["steps"] == 7
