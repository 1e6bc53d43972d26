from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import welch

from tactogram.datasets.simulate import RecordingTask, make, tasks
from tactogram.datasets.simulate.materials import PLATES, Plate, fine_heights
from tactogram.datasets.simulate.sensor import LAYERS, SENSOR, STABLE_S, trace_plate
from tactogram.datasets.simulate.surfaces import PATCH_MM, Grating, Surface
from tactogram.datasets.simulate.touch import plate_touched


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


def test_the_set_is_twelve_plates_of_ten_measurements():
    todo = tasks("ultrasonic", seed=0)
    assert len(todo) == 120
    assert len({task.surface for task in todo}) == 12
    assert [plate.name for plate in PLATES] == [f"plate{n:02d}" for n in range(1, 13)]
    assert make(todo[80]).id == measured(GROOVED).id


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


def test_relief_and_steepness_are_those_of_the_formula():
    wave = Plate(Surface("wave 01", (Grating(2.0, 0.2),), 0.4), "a cosine of 2 mm", 0.1)
    touched = plate_touched(wave)
    k = round(PATCH_MM / 2.0) / PATCH_MM
    assert touched.relief_mm == pytest.approx(0.1 / 2**0.5, rel=1e-3)
    assert touched.steepness == pytest.approx(0.1 / 2**0.5 * 2 * np.pi * k, rel=1e-3)
    assert touched.friction == pytest.approx(0.4, rel=0.1)
