"""Motion: late samples are dropped, speed comes from positions, contact from force."""

import math

import pytest

from tactogram.rendering.motion.finger_state import FingerState, MotionSample

NAN = math.nan


def at(time_s, x=0.0, *, late=0.0, force=NAN, speed=NAN):
    return MotionSample(time_s, time_s + late, x, 0.0, speed, force)


def test_a_late_sample_is_dropped_and_counted():
    finger = FingerState()
    assert finger.update(at(0.0), 0.0)
    assert not finger.update(at(0.010, 5.0, late=0.050), 0.060)
    assert finger.update(at(0.060, 6.0), 0.060)
    assert (finger.counts.used, finger.counts.late, finger.counts.dropped) == (2, 1, 1)


def test_a_sample_that_waited_too_long_is_dropped():
    finger = FingerState()
    finger.update(at(0.0), 0.0)
    assert not finger.update(at(0.001, 1.0), 0.050)
    assert finger.counts.late == 1


def test_a_clock_that_stood_still_is_late_for_a_second_and_not_for_ever():
    """A game's clock stops while it loads for 0.7 s."""
    finger = FingerState()
    used = []
    for i in range(400):
        now = i / 100
        used.append(finger.update(MotionSample(now - (0.7 if now >= 1 else 0.0), now, now, 0.0), now))
    assert all(used[:100])
    assert not any(used[171:200])
    assert all(used[275:])
    assert finger.counts.clocks_set == 1
    assert finger.newest_s == pytest.approx(3.99)


def test_samples_that_waited_for_the_engine_never_set_the_clock():
    finger = FingerState()
    finger.update(at(0.0), 0.0)
    assert not any(finger.update(at(i / 100), 5.0) for i in range(1, 300))
    assert finger.counts.clocks_set == 0


@pytest.mark.parametrize("absurd", [{"speed_mm_s": 3e38}, {"x_mm": 3e38, "y_mm": 0.0}, {"force_n": -1.0}])
def test_what_no_hand_does_is_invalid(absurd):
    finger = FingerState()
    assert not finger.update(MotionSample(0.0, 0.0, **absurd), 0.0)
    assert finger.counts.invalid == 1


def test_the_senders_clock_may_be_any():
    finger = FingerState()
    for i in range(100):
        t = i / 100
        assert finger.update(MotionSample(t + 1e6, t + 0.004 * (i % 2), t, 0.0), t + 0.004)
    assert finger.counts.late == 0
    assert finger.newest_s == pytest.approx(0.99, abs=1e-5)


def test_out_of_order_is_dropped_and_a_restarted_sender_is_heard():
    finger = FingerState()
    finger.update(at(10.0), 10.0)
    assert not finger.update(MotionSample(9.99, 10.001, 1.0, 0.0), 10.001)
    assert finger.update(MotionSample(0.5, 10.01, 1.0, 0.0), 10.01)
    assert finger.counts.out_of_order == 1


@pytest.mark.parametrize(
    "sample",
    [
        MotionSample(0.0, 0.0),
        MotionSample(0.0, 0.0, math.inf, 0.0),
        MotionSample(0.0, 0.0, 1.0),
        MotionSample(math.nan, 0.0, 1.0, 0.0),
        MotionSample(0.0, 0.0, speed_mm_s=-1.0),
        MotionSample(0.0, 0.0, force_n=-0.1),
    ],
)
def test_what_cannot_be_is_refused_and_counted(sample):
    finger = FingerState()
    assert not finger.update(sample, 0.0)
    assert finger.counts.invalid == 1


@pytest.mark.parametrize("rate", [60.0, 250.0, 1000.0])
def test_speed_of_a_steady_stroke_has_no_lag(rate):
    finger = FingerState()
    for i in range(int(rate)):
        finger.update(at(i / rate, 120 * i / rate), i / rate)
    assert finger.velocity(1.0)[0] == pytest.approx(120, rel=1e-6)
    assert finger.position(1.0)[0] == pytest.approx(120, rel=1e-6)


def test_a_given_speed_counts_and_the_positions_give_its_direction():
    finger = FingerState()
    for i in range(100):
        finger.update(at(i / 100, -50 * i / 100, speed=80.0), i / 100)
    assert finger.velocity(0.99) == pytest.approx((-80, 0), abs=1e-9)


def test_contact_has_hysteresis():
    finger = FingerState()
    states = []
    for i, force in enumerate((0.0, 0.03, 0.06, 0.03, 0.021, 0.019, 0.03)):
        finger.update(at(i / 100, force=force), i / 100)
        states.append(finger.touching)
    assert states == [False, False, True, True, True, False, False]
    assert finger.landing_n == 0.06


def test_silence_is_a_lost_connection_once():
    finger = FingerState()
    finger.update(at(0.0, force=1.0), 0.0)
    assert not finger.is_lost(0.05)
    assert finger.is_lost(0.2)
    assert finger.is_lost(0.3)
    assert finger.counts.lost_connections == 1
    assert not finger.touching
