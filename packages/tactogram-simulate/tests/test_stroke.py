"""Strokes of a hand."""

import numpy as np
import pytest

from tactogram_simulate.stroke import LENGTH_MM, TURN_M_S2, stroke


@pytest.mark.parametrize("speed", [100, 200, 400])
def test_a_stroke_goes_back_and_forth_at_the_speed_asked_for(speed):
    moved = stroke(
        np.random.default_rng(0),
        seconds=20,
        rate=1000,
        speed_mm_s=speed,
        force_n=0.7,
        back_and_forth=True,
        unsteadiness=0,
    )
    velocity = np.diff(moved.path_mm) * 1000
    assert np.median(np.abs(velocity)) == pytest.approx(speed, rel=0.01)
    assert np.abs(velocity).max() == pytest.approx(speed, rel=0.01)
    assert np.ptp(moved.path_mm) == pytest.approx(LENGTH_MM, rel=0.1)
    assert np.abs(np.diff(velocity) * 1000).max() < 2.5 * 1e3 * TURN_M_S2
    np.testing.assert_allclose(moved.force_n, 0.7)
    np.testing.assert_allclose(moved.sideways_mm, 0)


def test_a_hand_stays_on_its_plate_and_presses_on():
    moved = stroke(
        np.random.default_rng(1), seconds=180, rate=500, speed_mm_s=200, force_n=0.7, back_and_forth=True
    )
    assert np.ptp(moved.path_mm) < 130
    assert moved.force_n.min() > 0
    assert moved.force_n.std() / 0.7 == pytest.approx(0.1, rel=0.4)
    assert np.ptp(moved.sideways_mm) > 1


@pytest.mark.parametrize("seed", range(8))
def test_a_hand_does_not_stop_dead_where_the_recording_ends(seed):
    moved = stroke(
        np.random.default_rng(seed),
        seconds=4,
        rate=2000,
        speed_mm_s=200,
        force_n=0.7,
        back_and_forth=True,
    )
    # m/s^2; a turn takes 2.5 times the mean.
    acceleration = np.diff(moved.path_mm, 2) * 2000**2 * 1e-3
    assert np.abs(acceleration).max() < 4 * TURN_M_S2


def test_a_stroke_in_one_direction_never_turns():
    moved = stroke(
        np.random.default_rng(2), seconds=4, rate=1000, speed_mm_s=100, force_n=0.7, back_and_forth=False
    )
    assert np.diff(moved.path_mm).min() >= 0
    assert moved.path_mm[-1] == pytest.approx(385, rel=0.05)
