"""Simulated sensors."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import welch

from tactogram_simulate import make, tasks
from tactogram_simulate.materials import PLATES, fine_heights
from tactogram_simulate.sensor import (
    GRAVITY,
    LAYERS,
    SENSOR,
    STABLE_S,
    sense,
    trace_plate,
    turn,
    wired,
    wireless,
)
from tactogram_simulate.stroke import RecordingTask
from tactogram_simulate.surfaces import PATCH_MM


def test_the_set_is_twelve_plates_of_ten_measurements():
    todo = tasks("ultrasonic", seed=0)
    assert len(todo) == 120
    assert len({task.surface for task in todo}) == 12
    assert [plate.name for plate in PLATES] == [f"plate{n:02d}" for n in range(1, 13)]
    assert make(todo[80]).id == measured(GROOVED).id


def test_the_sensor_has_steps_range_noise_and_losses():
    rng = np.random.default_rng(0)
    still = np.zeros((3, 160_000))
    level = np.zeros((3, 1))
    wire, lost = sense(still, 4000.0, level, wired(1000.0), rng)
    assert lost == 0
    assert wire.samples[2].mean() == pytest.approx(GRAVITY, abs=0.01)
    assert wire.samples[0].std() == pytest.approx(100e-6 * GRAVITY * np.sqrt(500), rel=0.05)
    steps = wire.samples / (32 * GRAVITY / 2**16)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-2)
    radio, lost = sense(still, 3960.0, level, wireless(330.0), rng)
    assert radio.rate == 330
    assert len(radio) == pytest.approx(330 * 160_000 / 3960, abs=2)
    assert 1 <= lost <= 20
    for axis, density in (("x", 290e-6), ("z", 430e-6)):
        noise = np.hypot(density * GRAVITY * np.sqrt(165), 0.004 * GRAVITY / 12**0.5)
        assert radio.axis(axis).std() == pytest.approx(noise, rel=0.1)
    loud, _ = sense(np.full((3, 4000), 500.0), 4000.0, level, wired(1000.0), rng)
    assert loud.samples.max() <= 16 * GRAVITY + 0.01


def test_a_wireless_sensor_sends_33_packets_of_ten_values_and_a_wired_one_has_1_khz():
    """Saga et al., Sec. II-A: "ten consecutive measurement values are stored in one packet", 33 Hz, so 330 Hz."""
    assert (wireless().packet, wireless().rate) == (10, 10 * 33)
    assert (wired().packet, wired().rate) == (1, 1000)  # Sec. III-B


def test_lost_packets_add_nothing_that_was_not_there():
    rng = np.random.default_rng(0)
    shaken = 20 * rng.standard_normal((3, 80_000))
    radio, lost = sense(shaken, 3960.0, np.zeros((3, 1)), replace(wireless(), lost=0.2), rng)
    assert lost > 50
    assert np.abs(radio.samples).max() < 1.5 * 20 * 5 / np.sqrt(12)


def test_turning_keeps_the_length():
    signal, _ = sense(
        np.zeros((3, 8000)), 4000.0, np.array([[0.3], [-0.2], [1.0]]), wired(1000.0), np.random.default_rng(0)
    )
    assert np.linalg.norm(signal.samples.mean(1)) == pytest.approx(GRAVITY, rel=1e-3)
    # Leaning back about y shows gravity along the stroke.
    leaned = turn(np.array([[0.0], [0.0], [1.0]]), np.deg2rad([[0.0], [30.0], [0.0]]))
    np.testing.assert_allclose(np.abs(leaned[:, 0]), [0.5, 0, np.sqrt(0.75)], atol=1e-12)


def measured(plate, measurement=1, seed=0):
    return trace_plate(
        plate, RecordingTask("ultrasonic", seed, 0, SENSOR.name, 20.0, measurement, 2.5, 10_000.0)
    )


GROOVED = PLATES[8]


@pytest.fixture(scope="module")
def grooved():
    return measured(GROOVED)


def stable(recording):
    rate = recording.stream("strain").rate
    first, last = (round(s * rate) for s in STABLE_S)
    return recording.stream("strain").samples[:, first:last].astype(float)


def test_a_measurement_has_the_layout_of_the_study(grooved):
    """Hatori & Takemura 2023, Sec. III-B: "four strain gauges providing four vibration data"."""
    strain = grooved.stream("strain")
    assert (strain.rate, strain.unit, strain.axes) == (10_000.0, "V", ("g1", "g2", "g3", "g4"))
    assert len(strain) == 25_000
    assert stable(grooved).shape == (4, 20_000)
    assert (grooved.material, grooved.session, grooved.speed_mm_s, grooved.force_n) == (
        "plate09",
        "plate09-m01",
        20.0,
        0.98,
    )
    assert grooved.simulated
    assert "simulated" in grooved.history[0]


def test_ridges_are_heard_at_speed_over_period(grooved):
    x = stable(grooved)[0]
    frequency, power = welch(x, 10_000, nperseg=len(x))
    ridges = round(PATCH_MM / 2.5) / PATCH_MM * 20
    band = (frequency > 5) & (frequency < 60)
    assert frequency[band][power[band].argmax()] == pytest.approx(ridges, abs=0.75)


def test_opposed_gauges_disagree_and_the_two_layers_agree():
    """Front and back are bent opposite ways by shear and pressed alike: knurls shear most."""
    alike = np.corrcoef(stable(measured(PLATES[7])))
    assert -0.95 < alike[0, 1] < -0.3
    assert alike[0, 2] > 0.9
    assert -0.95 < alike[2, 3] < 0


def test_the_inner_layer_hears_deeper():
    """Above its resonance a layer falls at 12 dB per octave, so the inner one lacks most at 600 Hz."""
    x = stable(measured(PLATES[4]))
    frequency, power = welch(x, 10_000, nperseg=5000)
    high, low = ((frequency > a) & (frequency < b) for a, b in ((500, 700), (60, 120)))
    outer, inner = (10 * np.log10(power[g, high].sum() / power[g, low].sum()) for g in (0, 2))
    expected = 40 * np.log10(LAYERS[0].resonance_hz / LAYERS[1].resonance_hz)
    assert outer - inner == pytest.approx(expected, abs=5)


def test_measurements_differ_and_the_same_seed_gives_the_same_bits(grooved):
    assert measured(GROOVED).id == grooved.id
    assert measured(GROOVED, 2).id != grooved.id
    assert measured(GROOVED, seed=1).id != grooved.id


def test_a_wider_contact_feels_less_of_the_finest_roughness():
    place = np.linspace(0, 0.05, 20_000)
    fine, wide = (
        fine_heights(PLATES[4], replace(SENSOR, radius_mm=radius), place, np.random.default_rng(0)).std()
        for radius in (1.0, 2.0)
    )
    assert fine / wide == pytest.approx(2.0, rel=1e-3)
    assert fine < 1e-6 * PLATES[4].fine_um
