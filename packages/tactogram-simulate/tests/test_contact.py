"""Contact mechanics."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.signal import welch

from tactogram_simulate.contact import FINGER, PEN, Bristles, feel, transmission
from tactogram_simulate.stroke import Stroke
from tactogram_simulate.surfaces import PATCH_MM, Grating, Roughness, Surface

RATE = 8000.0


def steady(speed, seconds=2.0, force=0.7):
    n = int(seconds * RATE)
    return Stroke(RATE, np.arange(n) * speed / RATE, np.zeros(n), np.full(n, force))


@settings(deadline=None, max_examples=8)
@given(st.sampled_from([1.0, 1.6, 2.4, 4.0]), st.floats(40, 300), st.sampled_from([FINGER, PEN]))
def test_spatial_frequency_times_speed_is_what_is_felt(period, speed, contactor):
    ridges = Surface(f"ridges-{period}", (Grating(period, 0.02),), 0.4, 1.0)
    felt = feel(ridges, contactor, steady(speed), start_mm=(0, 0), direction_deg=0)
    f, power = welch(felt.normal[2000:], RATE, nperseg=len(felt.normal) - 2000)
    expected = speed * round(PATCH_MM / period) / PATCH_MM
    harmonic = np.round(f / expected)
    on_comb = (np.abs(f - harmonic * expected) <= 2 * f[1]) & (harmonic >= 1)
    # A slow pen feels a fine grating twice per period as strongly as once, so the strongest line alone says nothing.
    assert power[on_comb].sum() > 0.9 * power.sum()
    assert power[on_comb & (harmonic == 1)].sum() > 0.25 * power.sum()


@pytest.mark.parametrize("contactor", [FINGER, PEN])
def test_vibration_grows_with_speed(contactor):
    rough = Surface("rough", (Roughness(0.01, 2.0, 0.2, 4),), 0.4, 1.0)
    level = [
        feel(rough, contactor, steady(speed), start_mm=(0, 0), direction_deg=10).normal[2000:].std()
        for speed in (50, 100, 200, 400)
    ]
    assert np.all(np.diff(np.log(level)) > 0.2)


@pytest.mark.parametrize("contactor", [FINGER, PEN])
def test_the_shift_in_frequency_accounts_for_the_growth_with_speed(contactor):
    """What is felt at one speed says what is felt at others, by a shift alone (Greenspon et al. 2019)."""
    rough = Surface("rough", (Roughness(0.003, 2.0, 0.2, 4),), 0.4, 1.0, stiffness_n_m=1e9)

    def power_at(speed):
        moved = steady(speed, seconds=400 / speed)
        felt = feel(rough, contactor, moved, start_mm=(0, 0), direction_deg=10)
        return welch(felt.normal[2000:], RATE, nperseg=int(40 / speed * RATE))

    def gain(f):
        m, c, s = contactor.mass_kg, contactor.damping_n_s_m, contactor.stiffness_n_m
        w = 2 * np.pi * f
        return np.abs(w**2 * (1j * w * c + s) / (s - m * w**2 + 1j * w * c)) ** 2

    f, power = power_at(60)
    heights = power[1:] / gain(f[1:])
    for speed in (30, 120, 240):
        shift = speed / 60
        expected = (heights * gain(f[1:] * shift)).sum() * f[1]
        f_fast, power_fast = power_at(speed)
        assert power_fast.sum() * f_fast[1] == pytest.approx(expected, rel=0.15)


def dragged(speed, mass=1e-3, seconds=2.0):
    """Return a mass of 1 g on a spring of 1 N/mm over a flat surface: the parameters of the reference."""
    block = replace(
        FINGER, grip_mass_kg=mass, grip_n_m=1000.0, grip_n_s_m=0.0, stiffness_n_m=1000.0, damping_n_s_m=1.0
    )
    flat = Surface("flat", (Grating(1, 0),), friction=0.5, stiction=1.8, stribeck_mm_s=10)
    moved = steady(speed, seconds=seconds, force=0.5)
    steel = Bristles(1e5, 1e5**0.5, 0.4)  # Canudas de Wit et al. 1995
    return feel(flat, block, moved, start_mm=(0, 0), direction_deg=0, bristles=steel)


@pytest.mark.parametrize("speed", [10, 50])
def test_it_sticks_and_slips_when_slow(speed):
    felt = dragged(speed)
    friction = felt.friction_n[len(felt.friction_n) // 2 :]
    place = felt.place_m[len(felt.place_m) // 2 :]
    velocity = np.diff(place) * RATE
    assert np.ptp(friction) > 0.1
    assert np.mean(np.abs(velocity) < 2e-3) > 0.2
    assert velocity.mean() == pytest.approx(1e-3 * speed, rel=0.1)
    # Static friction is reached; what is above it is what bending the bristles adds (sigma1 z').
    assert 0.9 * 0.9 * 0.5 < friction.max() < 1.5 * 0.9 * 0.5


def test_it_slides_smoothly_when_fast():
    felt = dragged(250)
    half = len(felt.friction_n) // 2
    # Coulomb and viscous friction alone.
    assert felt.friction_n[half:].mean() == pytest.approx(0.5 * 0.5 + 0.4 * 0.25, rel=0.01)
    assert np.ptp(felt.friction_n[half:]) < 0.01
    assert np.abs(felt.along[half:]).max() < 1


@pytest.mark.parametrize("speed", [20, 100, 300])
def test_friction_takes_energy(speed):
    felt = dragged(speed, seconds=1.0)
    velocity = np.gradient(felt.place_m) * RATE
    assert (felt.friction_n * velocity).sum() > 0


def test_a_light_contactor_leaves_a_rough_surface_and_its_force_is_never_negative():
    ridges = Surface("high ridges", (Grating(2.0, 0.5),), 0.4)
    felt = feel(ridges, PEN, steady(400, 1.0), start_mm=(0, 0), direction_deg=0)
    assert felt.force_n.min() == 0
    flying = felt.force_n == 0
    # In the air the load of the hand alone pulls.
    free = flying & np.roll(flying, 1)
    np.testing.assert_allclose(felt.normal[free], -0.7 / PEN.mass_kg, rtol=1e-6)


def test_the_contact_follows_its_equation():
    """m z'' + b (z' - u') + k (z - u) = 0 for a small sine: gain and resonance as the formula says."""
    for period, speed in ((2.0, 100.0), (1.0, 200.0)):
        sine = Surface(f"sine-{period}", (Grating(period, 1e-4),), 0.4, 1.0, stiffness_n_m=1e9)
        felt = feel(sine, FINGER, steady(speed), start_mm=(0, 0), direction_deg=0)
        k = round(PATCH_MM / period) / PATCH_MM
        w = 2 * np.pi * k * speed
        u = 0.5e-7 * transmission(FINGER, np.array(k))
        m, c, s = FINGER.mass_kg, FINGER.damping_n_s_m, FINGER.stiffness_n_m
        expected = w**2 * u * abs((1j * w * c + s) / (s - m * w**2 + 1j * w * c))
        assert felt.normal[4000:].std() * np.sqrt(2) == pytest.approx(expected, rel=0.01)
